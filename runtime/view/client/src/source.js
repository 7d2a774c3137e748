// Where the page gets its run from. `sources.js` chooses one; the page knows only this interface.
//
// A source calls the functions of `on`:
//
//   scene({description, live, meshes, rows, count})  First, and again after a lost connection: the plain data of
//     description.py; `live` is false for a recorded run, which has all its `rows` (Float32Array, `count` of
//     them). `meshes` are the addresses of mesh files; without it they are requested from the server.
//   rows({whole, epoch, count, rows})  Rows, Float32Array of count * (2 + description.width): the time, s, as a sum
//     of two numbers, then the columns of the model. `whole` and a new `epoch` (a reset) discard those before.
//   state({playing, speed, actual, ended, epoch, ready})  Of the player; `actual` is the speed reached, 0: unknown.
//     Of a loop in real time also `loop: {words, lines}`, what the badge says and the lines of the report.
//   values({values})  Of all parameters, SI, in the order of the description.
//   fault({messages: [{code, text, help}], stopped, time})  Why a run stopped, or a value was refused.
//   graph(description)  The bond graph, once it was asked for: the plain data of graph.py.
//   powers({epoch, values})  While they are watched: e1, f1, e2, f2 .. of the scalar bonds of the graph, Float32Array.
//   lost(isLost)  The connection was lost, or is there again.
//
// It takes the commands `play`, `pause`, `step`, `reset`, `speed {value}`, `set {name, value}` (SI), and
// `hand {device, position, orientation, gripper, buttons}`: the pose that the page gives the device of that name, in m and
// in the axes of the device, which may be left to the scene again by `leave {device}`. Commands that
// a source does not know are ignored; `hasGraph` says whether it knows `graph` and `watch {value}` (true or false: begin or
// end `powers`), `hasSlots` whether it knows `use {slot, part}` (another model, which arrives as another `scene`).

export class Source {
  constructor(on) {
    this.on = on;
    this.hasGraph = this.hasSlots = false;
  }

  start() {}

  // Gives a command; nothing comes back but what it changes.
  send(_type, _content = {}) {}
}

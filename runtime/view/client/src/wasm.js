// WebAssembly modules of a page: unpacking, and what they import.

// Compiles a module, base64 of gzip.
export async function compileModule(packed) {
  const bytes = Uint8Array.from(atob(packed), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compile(await new Response(stream).arrayBuffer());
}

// An instance of a module. It needs a clock; whatever else the C library asks for does not exist.
export async function instantiate(module) {
  let memory = null;
  const known = {
    clock_time_get: (_clock, _precision, at) => {
      new DataView(memory.buffer).setBigUint64(at, BigInt(Math.round(1e6 * performance.now())), true);
      return 0;
    },
    proc_exit: (code) => {
      throw new Error(`the model ended with ${code}`);
    },
  };
  const absent = () => 52; // ENOSYS
  const imports = {};
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    imports[from] ??= {};
    imports[from][name] = known[name] ?? absent;
  }
  const { exports } = await WebAssembly.instantiate(module, imports);
  memory = exports.memory;
  exports._initialize?.();
  return exports;
}

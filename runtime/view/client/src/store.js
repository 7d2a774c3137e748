// Rows of a run: float32, the time as a sum of the first two columns, then the model's columns.

export const TIMES = 2;
const LIMIT = 12e6; // numbers; above it every second row is dropped

export class Store {
  constructor(width) {
    this.width = width + TIMES;
    this.data = new Float32Array(1024 * this.width);
    this.count = 0;
    this.version = 0;
  }

  clear() {
    this.count = 0;
    this.version++;
  }

  append(rows, count) {
    const needed = (this.count + count) * this.width;
    if (needed > this.data.length) this.grow(needed);
    this.data.set(rows.subarray(0, count * this.width), this.count * this.width);
    this.count += count;
    if (this.data.length > LIMIT && this.count * this.width > LIMIT) this.thin();
  }

  grow(needed) {
    const larger = new Float32Array(Math.max(needed, 2 * this.data.length));
    larger.set(this.data.subarray(0, this.count * this.width));
    this.data = larger;
  }

  thin() {
    const { width, data } = this;
    const kept = Math.ceil(this.count / 2);
    for (let k = 1; k < kept; k++) data.copyWithin(k * width, 2 * k * width, (2 * k + 1) * width);
    this.count = kept;
    this.version++;
  }

  time(row) {
    return this.data[row * this.width] + this.data[row * this.width + 1];
  }

  get first() {
    return this.count ? this.time(0) : 0;
  }

  get last() {
    return this.count ? this.time(this.count - 1) : 0;
  }

  // The last row that is not after a time; 0 before the first.
  find(time) {
    let low = 0;
    let high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time(middle) <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  // The columns of the model at a time, between two rows by interpolation.
  sample(time, target) {
    if (!this.count) return false;
    const { width, data } = this;
    const row = this.find(time);
    const from = row * width + TIMES;
    const start = this.time(row);
    const end = row + 1 < this.count ? this.time(row + 1) : start;
    const share = end > start ? Math.min(1, Math.max(0, (time - start) / (end - start))) : 0;
    for (let k = 0; k < width - TIMES; k++) {
      const a = data[from + k];
      target[k] = share > 0 ? a + share * (data[from + width + k] - a) : a;
    }
    return true;
  }

  // Columns of rows first .. last as arrays, in at most about 2 * buckets points: of each bucket of
  // rows the smallest and the largest value of the first column, so that no peak is lost.
  series(first, last, columns, factors, buckets) {
    const count = last - first + 1;
    const every = Math.max(1, Math.ceil(count / (2 * buckets)));
    const times = [];
    const values = columns.map(() => []);
    for (let row = first; row <= last; row += every) {
      times.push(this.time(row));
      columns.forEach((column, k) => {
        let value = this.data[row * this.width + TIMES + column];
        if (every > 1) value = this.extreme(row, Math.min(last, row + every - 1), column, value);
        values[k].push(Number.isFinite(value) ? value / factors[k] : null);
      });
    }
    return [times, ...values];
  }

  // The curves below and above a column by its error, at the rows and in the points of `series`.
  band(first, last, column, error, factor, buckets) {
    const every = Math.max(1, Math.ceil((last - first + 1) / (2 * buckets)));
    const [low, high] = [[], []];
    for (let start = first; start <= last; start += every) {
      let [least, largest] = [Infinity, -Infinity];
      for (let row = start; row <= Math.min(last, start + every - 1); row++) {
        const at = row * this.width + TIMES;
        least = Math.min(least, this.data[at + column] - this.data[at + error]);
        largest = Math.max(largest, this.data[at + column] + this.data[at + error]);
      }
      low.push(Number.isFinite(least) ? least / factor : null);
      high.push(Number.isFinite(largest) ? largest / factor : null);
    }
    return [low, high];
  }

  extreme(from, to, column, value) {
    let [low, high] = [value, value];
    for (let row = from; row <= to; row++) {
      const v = this.data[row * this.width + TIMES + column];
      if (v < low) low = v;
      if (v > high) high = v;
    }
    return value - low > high - value ? low : high;
  }
}

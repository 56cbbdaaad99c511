// Columns of numbers as a batch holds them (clew/page/batch.py, rule 3), and how they are looked up.

/** A column that grows, without a new array for every number. */
class Growing {
  constructor() {
    this.data = new Float64Array(64);
    this.length = 0;
  }

  /** @param {number} value */
  push(value) {
    if (this.length === this.data.length) {
      const wider = new Float64Array(2 * this.length);
      wider.set(this.data);
      this.data = wider;
    }
    this.data[this.length++] = value;
  }

  /** @param {number[]} deltas each less the one before @param {number} unit what one of them is */
  pushDeltas(deltas, unit) {
    let sum = 0;
    for (const delta of deltas) {
      sum += delta;
      this.push(sum * unit);
    }
  }

  get last() {
    return this.data[this.length - 1];
  }
}

/**
 * The last place whose time is not after `t`; -1: there is none.
 * @param {ArrayLike<number>} times in order @param {number} length @param {number} t
 */
function placeAt(times, length, t) {
  let low = 0;
  let high = length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** A curve: distances against time. */
class Curve {
  constructor() {
    this.t = new Growing();
    this.value = new Growing();
    this.least = Infinity;
    this.leastAt = 0;
  }

  /** @param {number[]} t in ms, as deltas @param {number[]} values in 0.1 mm, as deltas */
  add(t, values) {
    const from = this.value.length;
    this.t.pushDeltas(t, 1e-3);
    this.value.pushDeltas(values, 1e-4);
    for (let i = from; i < this.value.length; i++) this.note(i);
  }

  /** @param {number} t @param {number} value */
  push(t, value) {
    this.t.push(t);
    this.value.push(value);
    this.note(this.value.length - 1);
  }

  /** @param {number} i */
  note(i) {
    if (this.value.data[i] < this.least) {
      this.least = this.value.data[i];
      this.leastAt = this.t.data[i];
    }
  }

  /** @param {number} t @returns {number} NaN: not known yet */
  at(t) {
    const i = placeAt(this.t.data, this.t.length, t);
    return i < 0 ? NaN : this.value.data[Math.min(i, this.value.length - 1)];
  }
}

/** Rows of a kind of entry that share a key, in order of time. */
class Rows {
  constructor() {
    /** @type {number[]} */
    this.t = [];
    /** @type {number[]} */
    this.row = [];
  }

  /** @param {number} t @param {number} row */
  add(t, row) {
    let place = this.t.length;
    while (place > 0 && this.t[place - 1] > t) place--; // a robot's entries may come late
    this.t.splice(place, 0, t);
    this.row.splice(place, 0, row);
  }

  /** The newest row by then. @param {number} t @returns {number} -1: none */
  at(t) {
    const place = placeAt(this.t, this.t.length, t);
    return place < 0 ? -1 : this.row[place];
  }
}

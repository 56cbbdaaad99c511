// One run, as its batches tell it: what there is, and how it was at a time.

/** What `Run.kind` gives: the columns of a kind of entry. @typedef {Record<string, any[]>} Columns */

/** By which rows of a kind are looked up. @type {Record<string, (rows: Columns, i: number) => string | number | null>} */
const KEYS = {
  "order.accepted": (rows, i) => (rows.target[i] === null ? null : rows.robot[i]), // to stand still says nothing of the way
  "order.refused": (rows, i) => rows.robot[i],
  "scan.served": (rows, i) => rows.robot[i],
  "strand.joined": (rows, i) => robotOf(rows.source[i]),
  "step.planned": (rows, i) => robotOf(rows.source[i]),
  "segment.checked": (rows, i) => robotOf(rows.source[i]),
  "authority.granted": (rows, i) => `${robotOf(rows.source[i])}>${rows.to[i]}`,
};

const LAG_S = 0.5; // twice what poses have been seen to come late by, and more

/** @param {string} source @returns {number} 0: the world */
function robotOf(source) {
  return source.startsWith("r") ? Number(source.slice(1)) : 0;
}

class Run {
  constructor() {
    /** @type {any} */
    this.subject = null;
    this.scenario = sound(null);
    /** @type {any} */
    this.verdict = null;
    this.shortfall = "";
    /** @type {string[]} */
    this.flaws = [];
    this.end = 0;
    this.ended = false;
    /** @type {Map<number, Body>} */
    this.bodies = new Map();
    this.separation = new Curve();
    this.passing = new Curve();
    /** @type {{robot: number[], other: number[]}} */
    this.apart = { robot: [], other: [] };
    /** @type {Map<string, Columns>} */
    this.kinds = new Map();
    /** @type {Map<string, Map<string | number, Rows>>} */
    this.lookups = new Map();
    /** @type {Map<number, {t: number[], state: string[]}>} */
    this.lanes = new Map();
    /** @type {Map<string, {t: number[], state: string[]}>} */
    this.links = new Map();
    /** @type {{t_s: number, epoch: number, turn: number, order: number[]}[]} */
    this.strands = [];
    /** @type {Map<number, {x: number, y: number, s: number}[]>} */
    this.paths = new Map();
    /** @type {{t_s: number, robot: number, distances_m: number[]} | null} where the leader stood first */
    this.start = null;
    /** @type {Step[]} */
    this.steps = [];
    this.moments = new Moments();
    this.losses = new Losses();
  }

  get robots() {
    return [...this.bodies.keys()].sort((one, other) => one - other);
  }

  /** The newest time at which it is known where robots are: what they say may come before their poses do. */
  get newest() {
    if (this.ended) return this.end;
    const known = Math.max(0, ...[...this.bodies.values()].map((body) => body.t.last ?? 0));
    return Math.max(known, this.end - LAG_S); // where all stand, nothing is sampled
  }

  get radius() {
    const radius = this.scenario.fleet?.robot_radius_m;
    return isNumber(radius) ? radius : 0;
  }

  get epsilon() {
    const epsilon = this.scenario.law?.epsilon_m;
    return isNumber(epsilon) ? epsilon : 0;
  }

  get mu0() {
    const mu0 = this.scenario.law?.mu0_m;
    return isNumber(mu0) ? mu0 : 0;
  }

  /** Take a batch in. @param {any} batch */
  take(batch) {
    if (batch.subject) {
      this.subject = batch.subject;
      this.scenario = sound(batch.subject.scenario);
    }
    for (const track of batch.tracks ?? []) this.body(track.robot).add(track);
    for (const each of batch.clearances ?? []) this.body(each.robot).clearance.add(each.t, each.least);
    if (batch.separations) {
      this.separation.add(batch.separations.t, batch.separations.least);
      for (const robot of batch.separations.robot) this.apart.robot.push(robot);
      for (const other of batch.separations.other) this.apart.other.push(other);
    }
    if (batch.passings) this.passing.add(batch.passings.t, batch.passings.least);
    for (const lane of batch.lanes ?? []) change(this.lanes, lane.robot, lane);
    for (const link of batch.links ?? []) change(this.links, `${link.one}-${link.other}`, link);
    this.strands.push(...(batch.strands ?? []));
    this.strands.sort((one, other) => one.t_s - other.t_s);
    for (const [epoch, corners] of Object.entries(batch.paths ?? {}))
      this.paths.set(Number(epoch), arcs(corners));
    this.start = batch.start ?? this.start;
    for (const step of batch.steps ?? []) this.steps[step.place] = new Step(this, step);
    if (batch.losses) this.losses.take(batch.losses);
    this.losses.books = batch.books ?? this.losses.books;
    for (const [kind, columns] of Object.entries(batch.entries ?? {})) this.takeEntries(kind, columns);
    this.end = Math.max(this.end, batch.end_s ?? 0);
    this.ended ||= batch.ended ?? false;
    this.verdict = batch.verdict ?? this.verdict;
    this.shortfall = batch.shortfall ?? this.shortfall;
    this.flaws = batch.flaws ?? this.flaws;
  }

  /** @param {string} kind @param {Columns} columns */
  takeEntries(kind, columns) {
    const rows = this.kind(kind);
    const first = rows.t?.length ?? 0;
    for (const [name, values] of Object.entries(columns)) {
      const column = (rows[name] ??= []);
      let sum = 0;
      const isDelta = name === "t" || name === "i";
      for (const value of values) column.push(isDelta ? (sum += value) : value);
      if (name === "t") for (let i = first; i < column.length; i++) column[i] /= 1e3;
    }
    const key = KEYS[kind];
    for (let i = first; i < rows.t.length; i++) {
      const under = key ? key(rows, i) : null;
      if (under !== null) this.lookup(kind, under).add(rows.t[i], i);
      this.moments.add(kind, rows, i);
    }
  }

  /** @param {string} kind @returns {Columns} */
  kind(kind) {
    let rows = this.kinds.get(kind);
    if (!rows) this.kinds.set(kind, (rows = {}));
    return rows;
  }

  /** The rows of a kind by robot, or by link. @param {string} kind @param {string | number} key @returns {Rows} */
  lookup(kind, key) {
    let byKey = this.lookups.get(kind);
    if (!byKey) this.lookups.set(kind, (byKey = new Map()));
    let rows = byKey.get(key);
    if (!rows) byKey.set(key, (rows = new Rows()));
    return rows;
  }

  /** @param {number} robot @returns {Body} */
  body(robot) {
    let body = this.bodies.get(robot);
    if (!body) this.bodies.set(robot, (body = new Body(robot)));
    return body;
  }

  /** Put all bodies where they are at a time. @param {number} t */
  goTo(t) {
    for (const body of this.bodies.values()) body.goTo(t);
  }
}

/**
 * @template K
 * @param {Map<K, {t: number[], state: string[]}>} changes @param {K} key @param {{t_s: number, state: string}} to
 */
function change(changes, key, to) {
  let known = changes.get(key);
  if (!known) changes.set(key, (known = { t: [], state: [] }));
  known.t.push(to.t_s);
  known.state.push(to.state);
}

/** @param {{t: number[], state: string[]} | undefined} changes @param {number} t @returns {string} empty: none yet */
function stateAt(changes, t) {
  if (!changes) return "";
  const place = placeAt(changes.t, changes.t.length, t);
  return place < 0 ? "" : changes.state[place];
}

/** Corners with their arc length from the first. @param {[number, number][]} corners */
function arcs(corners) {
  let s = 0;
  return corners.map(([x, y], i) => {
    if (i > 0) s += Math.hypot(x - corners[i - 1][0], y - corners[i - 1][1]);
    return { x, y, s };
  });
}

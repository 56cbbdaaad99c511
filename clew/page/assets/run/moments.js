// Moments: the entries that a reader of the run looks for, each with a sign, a name and a sentence.

/**
 * How a kind is shown. `row` is its row above the lanes: 0 what went wrong or was done to the run, 1 how the strand
 * came through it; others are in the list alone.
 * @typedef {{sign: string, name: string, row: number, says: (rows: Columns, i: number) => string}} Sign
 */

/** @type {Record<string, Sign>} */
const SIGNS = {
  "promise.broken": {
    sign: "!",
    name: "promise broken",
    row: 0,
    says: (rows, i) => `${rows.invariant[i]}: robot ${rows.robot[i]}: ${rows.why[i]}`,
  },
  "robot.died": {
    sign: "×",
    name: "death",
    row: 0,
    says: (rows, i) =>
      `robot ${rows.robot[i]} is known to be dead, silent since ${rows.silent_since_s[i].toFixed(1)} s`,
  },
  "robot.failed": {
    sign: "×",
    name: "failure",
    row: 0,
    says: (rows, i) => `${rows.source[i]} has failed: ${rows.reason[i]}`,
  },
  "robot.restarted": {
    sign: "↻",
    name: "restart",
    row: 1,
    says: (rows, i) => `robot ${rows.robot[i]} was started again`,
  },
  "robot.returned": {
    sign: "↻",
    name: "return",
    row: 1,
    says: (rows, i) => `robot ${rows.robot[i]} is there again`,
  },
  "fault.injected": {
    sign: "ϟ",
    name: "fault",
    row: 0,
    says: (rows, i) => `${rows.rule[i]}: ${rows.fault[i]} ${rows.process[i]}`,
  },
  "router.lost": { sign: "⌀", name: "router lost", row: 0, says: () => "no router carries the fleet" },
  "router.found": {
    sign: "●",
    name: "router found",
    row: 1,
    says: (rows, i) => `a router carries the fleet again, after ${rows.away_s[i].toFixed(2)} s of wall clock`,
  },
  "world.resumed": {
    sign: "↻",
    name: "world resumed",
    row: 1,
    says: (rows, i) => `the world was started again, life ${rows.life[i]}`,
  },
  "link.silent": {
    sign: "○",
    name: "link silent",
    row: 0,
    says: (rows, i) =>
      `${rows.source[i]} does not hear robot ${rows.neighbour[i]}, for ${rows.silent_s[i].toFixed(2)} s`,
  },
  "link.heard": {
    sign: "◉",
    name: "link heard",
    row: 1,
    says: (rows, i) => `${rows.source[i]} hears robot ${rows.neighbour[i]} again`,
  },
  "link.broken": {
    sign: "⊘",
    name: "link broken",
    row: 0,
    says: (rows, i) => `${rows.source[i]} gives up its link to robot ${rows.neighbour[i]} (${rows.cause[i]})`,
  },
  "muster.called": {
    sign: "⊕",
    name: "muster",
    row: 1,
    says: (rows, i) => `${rows.source[i]} calls ${rows.members[i].length} robots to line up: ${rows.why[i]}`,
  },
  "leader.succeeded": {
    sign: "▲",
    name: "succession",
    row: 1,
    says: (rows, i) =>
      `${rows.source[i]} leads${rows.before[i] === null ? "" : ` in the place of robot ${rows.before[i]}`}`,
  },
  "strand.healed": {
    sign: "✚",
    name: "heal",
    row: 1,
    says: (rows, i) => `the strand has healed, of ${rows.members[i].length} robots`,
  },
  "strand.reversed": {
    sign: "⇄",
    name: "turn",
    row: 1,
    says: (rows, i) => `${rows.source[i]} has the strand turn round`,
  },
  "strand.dissolved": {
    sign: "⁘",
    name: "dissolved",
    row: 1,
    says: (rows, i) => `the strand dissolves: robot ${rows.blocked[i]} is blocked`,
  },
  "robot.placed": {
    sign: "◆",
    name: "join",
    row: 1,
    says: (rows, i) => `${rows.source[i]} has joined, at rank ${rows.rank[i] + 1}`,
  },
  "robot.blocked": {
    sign: "◇",
    name: "blocked",
    row: 0,
    says: (rows, i) => `${rows.source[i]} is blocked: ${rows.reason[i]}`,
  },
  "body.stopped": {
    sign: "■",
    name: "dead-man stop",
    row: 0,
    says: (rows, i) => `the body of robot ${rows.robot[i]} stops: its robot is silent`,
  },
  "step.abandoned": {
    sign: "⊣",
    name: "step abandoned",
    row: 0,
    says: (rows, i) => `${rows.source[i]} stops short of the end of step ${rows.step[i]}`,
  },
  "route.lost": {
    sign: "∅",
    name: "no route",
    row: 0,
    says: (rows, i) => `${rows.source[i]}: ${rows.reason[i]}`,
  },
  "goal.reached": {
    sign: "⚑",
    name: "goal",
    row: 1,
    says: (rows, i) => `${rows.source[i]} has reached the goal`,
  },
  "run.ended": { sign: "▐", name: "end", row: 3, says: (rows, i) => rows.reason[i] },
};

/** What a step says in the list; the time line has a band of its own for steps. @type {Sign} */
const STEP = {
  sign: "▷",
  name: "step",
  row: 2,
  says: (rows, i) =>
    `${rows.source[i]} plans step ${rows.step[i]}: ${rows.length_m[i].toFixed(2)} m` +
    (rows.promised_clearance_m[i] === null ? "" : `, promises ${rows.promised_clearance_m[i].toFixed(3)} m`),
};

/** @typedef {{t: number, kind: string, sign: Sign, rows: Columns, i: number}} Moment */

class Moments {
  constructor() {
    /** @type {Moment[]} in order of time */
    this.all = [];
  }

  /** @param {string} kind @param {Columns} rows @param {number} i */
  add(kind, rows, i) {
    const sign = kind === "step.planned" ? STEP : SIGNS[kind];
    if (!sign || (kind === "fault.injected" && rows.process[i] === null)) return; // messages are counted in `Losses`
    const moment = { t: rows.t[i], kind, sign, rows, i };
    let place = this.all.length;
    while (place > 0 && this.all[place - 1].t > moment.t) place--;
    this.all.splice(place, 0, moment);
  }

  /** The last moment by then. @param {number} t */
  placeAt(t) {
    let low = 0;
    let high = this.all.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.all[middle].t <= t) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }
}

/** @param {Moment} moment */
function sentence(moment) {
  return moment.sign.says(moment.rows, moment.i);
}

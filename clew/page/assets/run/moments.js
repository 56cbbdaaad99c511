// Moments: the entries that a reader of the run looks for, each with a sign, a name and the sentence of its entry.

/**
 * How a kind is shown. `row` is its row above the lanes: 0 what went wrong or was done to the run, 1 how the strand
 * came through it; others are in the list alone. The time line has a band of its own for steps.
 * @typedef {{sign: string, name: string, row: number}} Sign
 */

/** @type {Record<string, Sign>} */
const SIGNS = {
  "promise.broken": { sign: "!", name: "promise broken", row: 0 },
  "robot.died": { sign: "×", name: "death", row: 0 },
  "robot.failed": { sign: "×", name: "failure", row: 0 },
  "robot.restarted": { sign: "↻", name: "restart", row: 1 },
  "robot.returned": { sign: "↻", name: "return", row: 1 },
  "fault.injected": { sign: "ϟ", name: "fault", row: 0 },
  "router.lost": { sign: "⌀", name: "router lost", row: 0 },
  "router.found": { sign: "●", name: "router found", row: 1 },
  "world.resumed": { sign: "↻", name: "world resumed", row: 1 },
  "link.silent": { sign: "○", name: "link silent", row: 0 },
  "link.heard": { sign: "◉", name: "link heard", row: 1 },
  "link.broken": { sign: "⊘", name: "link broken", row: 0 },
  "view.proposed": { sign: "⊕", name: "view", row: 1 },
  "fence.changed": { sign: "⊟", name: "fence", row: 3 },
  "view.left": { sign: "◌", name: "left out", row: 0 },
  "robot.stranded": { sign: "⊥", name: "stranded", row: 0 },
  "leader.succeeded": { sign: "▲", name: "succession", row: 1 },
  "strand.healed": { sign: "✚", name: "heal", row: 1 },
  "strand.reversed": { sign: "⇄", name: "turn round", row: 1 },
  "strand.dissolved": { sign: "⁘", name: "dissolved", row: 1 },
  "robot.placed": { sign: "◆", name: "join", row: 1 },
  "robot.blocked": { sign: "◇", name: "blocked", row: 0 },
  "body.stopped": { sign: "■", name: "dead-man stop", row: 0 },
  "step.abandoned": { sign: "⊣", name: "step abandoned", row: 0 },
  "law.failed": { sign: "∅", name: "law failed", row: 0 },
  "route.lost": { sign: "∅", name: "no route", row: 0 },
  "goal.reached": { sign: "⚑", name: "goal", row: 1 },
  "run.ended": { sign: "▐", name: "end", row: 3 },
  "step.planned": { sign: "▷", name: "step", row: 2 },
};

/** The fence of an emergency stop. @type {Sign} */
const STOP = { sign: "⊗", name: "emergency stop", row: 0 };

/** @typedef {{t: number, i: number, kind: string, sign: Sign, says: string}} Moment `i`: its place in the log */

class Moments {
  constructor() {
    /** @type {Moment[]} in order of time */
    this.all = [];
  }

  /** @param {string} kind @param {Columns} rows @param {number} i */
  add(kind, rows, i) {
    const sign = kind === "fence.changed" && rows.may[i] === "stopped" ? STOP : SIGNS[kind];
    if (!sign || rows.says[i] === null) return; // nobody looks for it
    const moment = { t: rows.t[i], i: rows.i[i], kind, sign, says: rows.says[i] };
    let place = this.all.length;
    while (place > 0 && isLater(this.all[place - 1], moment)) place--;
    this.all.splice(place, 0, moment);
  }
}

/** @param {Moment} one @param {Moment} other */
function isLater(one, other) {
  return one.t > other.t || (one.t === other.t && one.i > other.i);
}

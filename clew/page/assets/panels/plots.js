// What there is to be seen against time: clearance, separation, passings, stretch of links, messages lost.

/**
 * @typedef {{name: string, key: number, curve: Curve, steps?: boolean, isOther?: boolean, who?: (i: number) => string}} Series
 *   `key`: the robot whose colour and dash it has; 0: it is of the whole fleet
 * @typedef {{value: number, name: string, dash: number[]}} Mark a height that means something
 * @typedef {{id: string, title: string, about: string, series: (run: Run) => Series[], marks: (run: Run) => Mark[],
 *   top: (run: Run, most: number, least: number) => number, decimals: number, none: (run: Run) => string,
 *   isOf?: (run: Run) => boolean}} Plot `isOf`: whether a run has such a thing at all
 */

const CROWD = 12; // robots: of more, the curves are faint, and the least of all is drawn over them
const PIECES = 400; // of the run's time, in each of which the least is taken

/** The least clearance of all robots against time. @param {Run} run */
function leastOfAll(run) {
  const piece = Math.max(run.end, 1e-3) / PIECES;
  const least = new Array(PIECES + 1).fill(Infinity);
  for (const { clearance } of run.bodies.values()) {
    let at = 0;
    for (let i = 0; i < clearance.value.length; i++) {
      const next = Math.min(Math.floor(clearance.t.data[i] / piece), PIECES);
      if (i) for (; at < next; at++) least[at] = Math.min(least[at], clearance.value.data[i - 1]); // it stood, or rolled on
      at = next;
      least[at] = Math.min(least[at], clearance.value.data[i]);
    }
    if (clearance.value.length) for (; at <= PIECES; at++) least[at] = Math.min(least[at], clearance.value.last);
  }
  const curve = new Curve();
  least.forEach((value, i) => value < Infinity && curve.push((i + 0.5) * piece, value));
  return curve;
}

/** @type {Plot[]} */
const PLOTS = [
  {
    id: "clearance",
    title: "Clearance [m]",
    about: "of each robot: from its hull to the nearest fixed obstacle, the least since the previous sample",
    series: (run) => [
      ...run.robots.map((robot) => ({ name: `r${robot}`, key: robot, curve: run.body(robot).clearance })),
      ...(run.bodies.size > CROWD ? [{ name: "all", key: 0, curve: leastOfAll(run) }] : []),
    ],
    marks: (run) => [
      { value: run.epsilon, name: "ε", dash: [] },
      { value: run.epsilon - run.mu0, name: "ε − μ0", dash: [5, 3] },
    ],
    top: (run, most, least) => Math.min(most, Math.max(5 * run.epsilon, 1.5 * least)),
    decimals: 3,
    none: (run) => (run.subject?.clearance_m_required == null ? NOT_KNOWN : "no fixed obstacle"),
  },
  {
    id: "separation",
    title: "Separation [m]",
    about: "the least distance between two hulls",
    series: (run) => [
      {
        name: "hulls",
        key: 0,
        curve: run.separation,
        who: (i) => `r${run.apart.robot[i]} and r${run.apart.other[i]}`,
      },
    ],
    marks: (run) =>
      run.subject?.separation_m_required
        ? [{ value: run.subject.separation_m_required, name: "required", dash: [5, 3] }]
        : [],
    top: (run, most, least) =>
      Math.min(most, Math.max(8 * (run.subject?.separation_m_required ?? 0), 4 * least)),
    decimals: 3,
    none: (run) => (run.subject?.separation_m_required == null ? NOT_KNOWN : "only one robot"),
  },
  {
    id: "passing",
    title: "To moving obstacles [m]",
    about: "the least distance of a driving robot's hull to a moving obstacle; it must be above 0; a standing robot may be touched",
    series: (run) => [{ name: "nearest", key: 0, curve: run.passing, who: () => "driving" }],
    marks: () => [],
    top: (run, most, least) => Math.min(most, Math.max(8 * run.epsilon, 4 * least)),
    decimals: 3,
    none: () => "no robot drove",
    isOf: (run) => run.scenario.moving.length > 0,
  },
  {
    id: "stretch",
    title: "Stretch of links [m]",
    about: "how far each robot is behind the end of its grant; beyond the limit, the robot ahead holds",
    series: stretches,
    marks: (run) =>
      run.scenario.fleet?.link_length_m_max
        ? [{ value: run.scenario.fleet.link_length_m_max, name: "limit", dash: [5, 3] }]
        : [],
    top: (run, most) => Math.max(most, 1.1 * (run.scenario.fleet?.link_length_m_max ?? 0)),
    decimals: 2,
    none: () => "no ground was granted",
  },
  {
    id: "losses",
    title: "Messages lost, by link",
    about: "state messages that faults have removed or damaged so far",
    series: (run) =>
      [...run.losses.taken].map(([link, curve]) => ({
        name: link,
        key: Number(link.split(" ")[0]),
        curve,
        steps: true,
      })),
    marks: () => [],
    top: (_, most) => Math.max(most, 4),
    decimals: 0,
    none: () => "no fault removed a link message",
  },
];

/** How far each robot is short of its grant, at the places of its track. @param {Run} run @returns {Series[]} */
function stretches(run) {
  /** @type {Series[]} */
  const found = [];
  for (const body of run.bodies.values()) {
    const curve = new Curve();
    let place = 0;
    for (let i = 0; i < body.t.length; i++) {
      const t = body.t.data[i];
      while (place + 1 < run.strands.length && run.strands[place + 1].t_s <= t) place++;
      const strand = run.strands[place];
      const rank = strand ? strand.order.indexOf(body.robot) : -1;
      if (rank < 1) continue;
      const short =
        authorityAt(run, strand, rank, t) -
        progressAt(run, body, strand, t, body.xs.data[i], body.ys.data[i]);
      if (!Number.isNaN(short)) curve.push(t, Math.max(short, 0));
    }
    if (curve.value.length) found.push({ name: `r${body.robot}`, key: body.robot, curve });
  }
  return found.sort((one, other) => one.key - other.key);
}

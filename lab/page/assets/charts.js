// Distances against time: clearance, separation, stretch of links, messages lost.

/**
 * @typedef {{name: string, key: number, curve: Curve, steps?: boolean, who?: (i: number) => string}} Series
 *   `key`: the robot whose colour and dash it has; 0: it is of the whole fleet
 * @typedef {{value: number, name: string, dash: number[]}} Mark a height that means something
 * @typedef {{id: string, title: string, about: string, series: (run: Run) => Series[], marks: (run: Run) => Mark[],
 *   top: (run: Run, most: number, least: number) => number, decimals: number, none: (run: Run) => string}} Plot
 */

/** @type {Plot[]} */
const PLOTS = [
  {
    id: "clearance",
    title: "Clearance of each robot [m]",
    about: "hull to the nearest obstacle that never moves, the least since the sample before",
    series: (run) =>
      run.robots.map((robot) => ({ name: `r${robot}`, key: robot, curve: run.body(robot).clearance })),
    marks: (run) => [
      { value: run.epsilon, name: "ε", dash: [] },
      { value: run.epsilon - run.mu0, name: "ε − μ0", dash: [5, 3] },
    ],
    top: (run, most, least) => Math.min(most, Math.max(5 * run.epsilon, 1.5 * least)),
    decimals: 3,
    none: (run) => (run.subject?.clearance_m_required == null ? NOT_KNOWN : "no obstacle stands still"),
  },
  {
    id: "separation",
    title: "Separation [m]",
    about:
      "the two hulls nearest to each other; with moving obstacles, also the nearest that a driving hull passed",
    series: (run) => [
      {
        name: "hulls",
        key: 0,
        curve: run.separation,
        who: (i) => `r${run.apart.robot[i]} and r${run.apart.other[i]}`,
      },
      { name: "a moving obstacle", key: 5, curve: run.passing },
    ],
    marks: (run) =>
      run.subject?.separation_m_required
        ? [{ value: run.subject.separation_m_required, name: "required", dash: [5, 3] }]
        : [],
    top: (run, most, least) =>
      Math.min(most, Math.max(8 * (run.subject?.separation_m_required ?? 0), 4 * least)),
    decimals: 3,
    none: (run) => (run.subject?.separation_m_required == null ? NOT_KNOWN : "one robot alone"),
  },
  {
    id: "stretch",
    title: "Stretch of links [m]",
    about: "how far each robot is short of what it has been granted; beyond the limit the robot ahead holds",
    series: stretches,
    marks: (run) =>
      run.scenario.fleet?.link_length_m_max
        ? [{ value: run.scenario.fleet.link_length_m_max, name: "limit", dash: [5, 3] }]
        : [],
    top: (run, most) => Math.max(most, 1.1 * (run.scenario.fleet?.link_length_m_max ?? 0)),
    decimals: 2,
    none: () => "nothing was granted",
  },
  {
    id: "losses",
    title: "Messages lost, by link",
    about: "state messages that faults took away or damaged, so far",
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
    none: () => "no fault took a message of a link",
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
        progressAt(run, body, strand.epoch, t, body.xs.data[i], body.ys.data[i]);
      if (!Number.isNaN(short)) curve.push(t, Math.max(short, 0));
    }
    if (curve.value.length) found.push({ name: `r${body.robot}`, key: body.robot, curve });
  }
  return found.sort((one, other) => one.key - other.key);
}

/** @param {Series} series */
function leastOf({ curve, name, who }) {
  const i = placeAt(curve.t.data, curve.t.length, curve.leastAt);
  return `least ${curve.least.toFixed(4)} m, ${who ? who(i) : name}, at ${curve.leastAt.toFixed(1)} s`;
}

const MARGIN = { left: 40, right: 30, top: 8, bottom: 20 };

class Chart {
  /** @param {App} app @param {Plot} plot @param {HTMLElement} home */
  constructor(app, plot, home) {
    this.app = app;
    this.plot = plot;
    this.still = new Still();
    /** @type {Series[]} */
    this.series = [];
    this.most = 1;
    this.known = -1;
    const figure = document.createElement("figure");
    figure.className = "chart";
    figure.innerHTML = `<figcaption><b></b> <span class="least"></span></figcaption><canvas tabindex="-1" role="img"></canvas>`;
    this.canvas = /** @type {HTMLCanvasElement} */ (figure.querySelector("canvas"));
    this.least = /** @type {HTMLElement} */ (figure.querySelector(".least"));
    /** @type {HTMLElement} */ (figure.querySelector("b")).textContent = plot.title;
    figure.title = plot.about;
    this.figure = figure;
    home.append(figure);
    scrubbing(this.canvas, app, (x, width) => (x - MARGIN.left) / (width - MARGIN.left - MARGIN.right));
  }

  /** Look again at what there is to draw. */
  refresh() {
    const run = this.app.run;
    this.known = this.app.news;
    this.series = this.plot.series(run).filter((each) => each.curve.value.length > 0);
    let most = 0;
    let lowest = null;
    for (const each of this.series) {
      for (let i = 0; i < each.curve.value.length; i++) most = Math.max(most, each.curve.value.data[i]);
      if (lowest === null || each.curve.least < lowest.curve.least) lowest = each;
    }
    this.most = this.plot.top(run, most, lowest ? lowest.curve.least : 0) || 1;
    const isDistance = this.plot.decimals === 3;
    this.least.textContent =
      isDistance && lowest ? leastOf(lowest) : this.series.length ? "" : this.plot.none(run);
    this.figure.classList.toggle("empty", this.series.length === 0);
    this.canvas.setAttribute(
      "aria-label",
      `${this.plot.title}: ${this.least.textContent || `${this.series.length} curves`}`,
    );
  }

  draw() {
    const { context, width, height } = surfaceOf(this.canvas);
    if (width === 0) return;
    if (this.known !== this.app.news) this.refresh();
    context.clearRect(0, 0, width, height);
    const key = `${this.app.news}|${this.app.focus}|${this.app.robot}`;
    this.still.show(context, width, height, key, (onto) => drawStill(this, onto, width, height));
    const x = this.x(this.app.time, width);
    context.strokeStyle = colour.ink;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(x, MARGIN.top);
    context.lineTo(x, height - MARGIN.bottom);
    context.stroke();
    for (const each of this.series) {
      const value = each.curve.at(this.app.time);
      if (Number.isNaN(value) || (this.app.robot && each.key && each.key !== this.app.robot)) continue;
      context.fillStyle = colourOf(each.key);
      context.beginPath();
      context.arc(x, this.y(value, height), 2.75, 0, 2 * Math.PI);
      context.fill();
    }
  }

  /** @param {number} t @param {number} width */
  x(t, width) {
    const share = Math.min(t / Math.max(this.app.end, 1e-3), 1); // a run that goes on is ahead of its axis
    return MARGIN.left + share * (width - MARGIN.left - MARGIN.right);
  }

  /** @param {number} value @param {number} height */
  y(value, height) {
    const share = Math.min(Math.max(value / this.most, -0.02), 1);
    return height - MARGIN.bottom - share * (height - MARGIN.top - MARGIN.bottom);
  }
}

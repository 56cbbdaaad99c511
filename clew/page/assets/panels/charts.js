// A chart: curves against time, to look at and to scrub on.

/** @param {Series} series */
function leastOf({ curve, name, who }) {
  const i = placeAt(curve.t.data, curve.t.length, curve.leastAt);
  return `least ${curve.least.toFixed(4)} m, ${who ? who(i) : name}, at ${curve.leastAt.toFixed(1)} s`;
}

const MARGIN = { left: 40, right: 30, top: 8, bottom: 20 };

/** What a plot shows of another run, in the time of the one in focus. @param {Plot} plot @param {Run} other @param {Run} run @param {string} letter @returns {Series[]} */
function seriesOf(plot, other, run, letter) {
  const timeOf = alignment(other, run);
  return plot.series(other).map(({ name, key, curve, steps }) => {
    const moved = new Curve();
    for (let i = 0; i < curve.value.length; i++) moved.push(timeOf(curve.t.data[i]), curve.value.data[i]);
    return { name: `${letter}: ${name}`, key, curve: moved, steps, isOther: true };
  });
}

class Chart {
  /** @param {App} app @param {Plot} plot @param {HTMLElement} home */
  constructor(app, plot, home) {
    this.app = app;
    this.plot = plot;
    this.still = new Still();
    /** @type {Series[]} */
    this.series = [];
    /** @type {Series[]} of the other run, where there are two, in the time of this one */
    this.others = [];
    this.most = 1;
    this.isCut = false; // curves go on above the top
    this.known = -1;
    const figure = document.createElement("figure");
    figure.className = "chart";
    figure.innerHTML = `<figcaption><b></b> <span class="least"></span></figcaption><canvas></canvas>`;
    this.canvas = /** @type {HTMLCanvasElement} */ (figure.querySelector("canvas"));
    this.least = /** @type {HTMLElement} */ (figure.querySelector(".least"));
    /** @type {HTMLElement} */ (figure.querySelector("b")).textContent = plot.title;
    /** @type {HTMLElement} */ (figure.querySelector("figcaption")).title = `${plot.about}; ▴: a curve continues above the top`;
    this.figure = figure;
    home.append(figure);
    scrubbing(this.canvas, app, MARGIN);
    hovering(this.canvas, (x, y) => sayChart(this, x, y));
  }

  /** Look again at what there is to draw. */
  refresh() {
    const run = this.app.run;
    this.known = this.app.news;
    this.series = this.plot.series(run).filter((each) => each.curve.value.length > 0);
    this.others = this.app.runs.flatMap((other, i) => (other === run ? [] : seriesOf(this.plot, other, run, "ABCDEFGH"[i])));
    let most = 0;
    let lowest = null;
    for (const { curve } of this.others)
      for (let i = 0; i < curve.value.length; i++) most = Math.max(most, curve.value.data[i]);
    for (const each of this.series) {
      for (let i = 0; i < each.curve.value.length; i++) most = Math.max(most, each.curve.value.data[i]);
      if (lowest === null || each.curve.least < lowest.curve.least) lowest = each;
    }
    this.most = this.plot.top(run, most, lowest ? lowest.curve.least : 0) || 1;
    this.isCut = most > this.most;
    const isDistance = this.plot.decimals === 3;
    const said = isDistance && lowest ? leastOf(lowest) : this.series.length ? "" : this.plot.none(run);
    const letter = "ABCDEFGH"[this.app.focus];
    const told = this.others.length && this === this.app.charts[0] ? `${letter} solid, the other dotted; ${said}` : said;
    this.least.textContent = this.isCut ? `${told}; ▴ > ${this.most.toFixed(2)} m` : told;
    this.figure.hidden = !(this.plot.isOf?.(run) ?? true);
    this.figure.classList.toggle("empty", this.series.length === 0);
    this.canvas.setAttribute(
      "aria-label",
      `${this.plot.title}: ${this.least.textContent || `${this.series.length} curves`}`,
    );
  }

  draw() {
    if (this.known !== this.app.news) this.refresh(); // which may bring it into sight
    const { context, width, height } = surfaceOf(this.canvas);
    if (width === 0) return;
    context.clearRect(0, 0, width, height);
    const { span } = this.app;
    const key = `${this.app.news}|${this.app.focus}|${this.app.robot}|${span.from}|${span.to}`;
    this.still.show(context, width, height, key, (onto) => drawStill(this, onto, width, height));
    tellTime(this.canvas, this.app, () => chartNow(this));
    const x = this.x(this.app.time, width);
    context.lineWidth = 1;
    drawTime(this.app, context, (t) => this.x(t, width), MARGIN.top, height - MARGIN.bottom);
    if (this.app.time < span.from || this.app.time > span.to) return;
    for (const each of this.series) {
      const value = each.curve.at(this.app.time);
      if (!(value <= this.most) || (this.app.robot && each.key && each.key !== this.app.robot)) continue;
      context.fillStyle = colourOf(each.key);
      context.beginPath();
      context.arc(x, this.y(value, height), 2.75, 0, 2 * Math.PI);
      context.fill();
    }
  }

  /** @param {number} t @param {number} width */
  x(t, width) {
    return MARGIN.left + this.app.span.share(t) * (width - MARGIN.left - MARGIN.right);
  }

  /** @param {number} value @param {number} height */
  y(value, height) {
    const share = Math.max(value / this.most, -0.02);
    return height - MARGIN.bottom - share * (height - MARGIN.top - MARGIN.bottom);
  }
}

// The time line: steps, what went wrong and what was mended, and a lane for each robot with what it did.

const LANE = { left: 64, right: 16, axis: 20, band: 18, signs: 18, top: 4, least: 3, most: 17, name: 9 };

class Lanes {
  /** @param {App} app @param {HTMLCanvasElement} canvas */
  constructor(app, canvas) {
    this.app = app;
    this.canvas = canvas;
    this.home = /** @type {HTMLElement} */ (canvas.parentElement);
    this.still = new Still();
    scrubbing(canvas, app, LANE);
    hovering(canvas, (x, y) => sayLanes(this, x, y));
    canvas.addEventListener("click", (event) => {
      const lane = Math.floor((event.offsetY - this.lanesTop) / this.laneHeight);
      const robot = app.run.robots[lane];
      if (event.offsetX < LANE.left && robot) app.choose(robot, app.focus);
    });
  }

  /** Of one robot [px]: as much as there is room for, so that all are seen at once. */
  get laneHeight() {
    const room = parseFloat(getComputedStyle(this.home).maxHeight) - this.lanesTop - LANE.axis;
    const each = Math.floor(room / Math.max(this.app.run.bodies.size, 1));
    return Math.min(Math.max(each, LANE.least), LANE.most);
  }

  get lanesTop() {
    return LANE.top + LANE.band + 2 * LANE.signs + 4;
  }

  draw() {
    const { app } = this;
    const tall = this.lanesTop + app.run.bodies.size * this.laneHeight + LANE.axis;
    if (this.canvas.style.height !== `${tall}px`) this.canvas.style.height = `${tall}px`;
    const { context, width, height } = surfaceOf(this.canvas);
    if (width === 0) return;
    context.clearRect(0, 0, width, height);
    const key = `${app.news}|${app.focus}|${app.robot}|${app.span.from}|${app.span.to}`;
    this.still.show(context, width, height, key, (onto) => this.drawStill(onto, width, height));
    context.lineWidth = 1.5;
    drawTime(app, context, (t) => this.x(t, width), LANE.top, height - LANE.axis);
    const x = this.x(app.time, width);
    context.fillStyle = colour.ink;
    context.beginPath();
    context.moveTo(x - 5, 0);
    context.lineTo(x + 5, 0);
    context.lineTo(x, 7);
    context.fill();
    tellTime(this.canvas, app, () => lanesNow(app));
  }

  /** @param {number} t @param {number} width */
  x(t, width) {
    return LANE.left + this.app.span.share(t) * (width - LANE.left - LANE.right);
  }

  /** @param {CanvasRenderingContext2D} context @param {number} width @param {number} height */
  drawStill(context, width, height) {
    drawTimeAxis(context, this.app.span, LANE.left, width - LANE.right, height - LANE.axis);
    this.nameRows(context);
    context.save();
    context.beginPath(); // what is outside of the time shown is cut off
    context.rect(LANE.left - 6, 0, width - LANE.left - LANE.right + 12, height);
    context.clip();
    this.drawSteps(context, width);
    drawSigns(this, context, width);
    this.drawDoings(context, width);
    context.restore();
  }

  /** @param {CanvasRenderingContext2D} context */
  nameRows(context) {
    const { run } = this.app;
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.font = font(11, "600");
    context.fillStyle = colour.soft;
    ["step", "faults", "mended"].forEach((name, row) =>
      context.fillText(name, LANE.left - 8, LANE.top + (row ? LANE.band + (row - 0.5) * LANE.signs : LANE.band / 2)),
    );
    const { laneHeight } = this;
    const every = Math.ceil(LANE.name / laneHeight); // of thin lanes not all have room for their names
    run.robots.forEach((robot, lane) => {
      const y = this.lanesTop + lane * laneHeight;
      const isChosen = robot === this.app.robot;
      context.fillStyle = isChosen ? colour.ink : colourOf(robot);
      context.font = font(Math.min(12, Math.max(laneHeight - 1, LANE.name)), isChosen ? "800" : "600");
      context.textAlign = "right";
      context.textBaseline = "middle";
      if (isChosen || lane % every === 0)
        context.fillText(`${isChosen ? "▸ " : ""}r${robot}`, LANE.left - (isChosen && every > 1 ? 26 : 8), y + laneHeight / 2);
    });
  }

  /** @param {CanvasRenderingContext2D} context @param {number} width */
  drawDoings(context, width) {
    const { run, span } = this.app;
    const { laneHeight } = this;
    run.robots.forEach((robot, lane) => {
      const y = this.lanesTop + lane * laneHeight;
      for (const part of doings(run, robot)) {
        if (part.to < span.from || part.from > span.to) continue;
        const [from, to] = [this.x(part.from, width), this.x(part.to, width)];
        drawDoing(
          context,
          part.does,
          from,
          Math.max(to - from, 0.5),
          y + laneHeight * 0.09,
          laneHeight * 0.82,
          colourOf(robot),
        );
      }
    });
  }

  /** @param {CanvasRenderingContext2D} context @param {number} width */
  drawSteps(context, width) {
    context.font = font(11, "600");
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (const [i, { step, end, from: fromTime, to: toTime }] of this.app.run.steps.entries()) {
      const [from, to] = [this.x(fromTime, width), this.x(toTime, width)];
      context.globalAlpha = i % 2 ? 0.28 : 0.16;
      context.fillStyle = colour.promise;
      context.fillRect(from, LANE.top, to - from, LANE.band - 3);
      context.globalAlpha = 1;
      context.fillStyle = colour.ink;
      if (to - from > 13)
        context.fillText(String(step), (from + to) / 2, LANE.top + LANE.band / 2 - 1);
      if (!end) continue; // it is under way
      context.fillStyle = end === "finished" ? colour.ink : colour.bad;
      context.fillRect(to - 0.5, LANE.top, end === "finished" ? 1 : 3, LANE.band - 3);
    }
  }
}

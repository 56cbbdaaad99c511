// More layers of a map: what the leader saw and chose, what stands in the way, links.

/** @param {Scene} scene */
function drawSight({ context, view, run, t, px, plans }) {
  const row = run.lookup("step.planned", plans).at(t);
  if (row < 0) return;
  const steps = run.kind("step.planned");
  const [seen, gaps, ends] = [steps.obstacles[row], steps.gaps[row], steps.ends[row]];
  context.strokeStyle = context.fillStyle = colour.ink;
  context.lineWidth = 1.5 * px;
  for (const { tangent_1: one, tangent_2: other } of seen) {
    stroke(context, one, other);
    for (const [x, y] of [one, other]) diamond(context, x, y, 3.5 * px);
  }
  gaps.forEach((/** @type {any} */ gap, /** @type {number} */ i) => {
    if (i === steps.gap[row] || !ends[i]) return;
    context.globalAlpha = gap.passable ? 0.5 : 0.25;
    context.lineWidth = px;
    context.setLineDash(gap.passable ? [5 * px, 3 * px] : [1 * px, 3 * px]);
    stroke(context, ends[i][0], ends[i][1]);
  });
  context.setLineDash([]);
  context.globalAlpha = 1;
  const chosen = ends[steps.gap[row]];
  if (chosen) drawGap(context, view, run, px, chosen[0], chosen[1], gaps[steps.gap[row]].width_m);
  drawHeading(context, px, [steps.x_m[row], steps.y_m[row]], pair(steps.target[row]));
}

/** @param {CanvasRenderingContext2D} context @param {number[]} one @param {number[]} other */
function stroke(context, one, other) {
  context.beginPath();
  context.moveTo(one[0], one[1]);
  context.lineTo(other[0], other[1]);
  context.stroke();
}

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {number} reach */
function diamond(context, x, y, reach) {
  context.beginPath();
  context.moveTo(x - reach, y);
  context.lineTo(x, y - reach);
  context.lineTo(x + reach, y);
  context.lineTo(x, y + reach);
  context.fill();
}

/** The gap that was aimed at, with its width. @param {CanvasRenderingContext2D} context @param {View} view @param {Run} run @param {number} px @param {number[]} right @param {number[]} left @param {number} width */
function drawGap(context, view, run, px, right, left, width) {
  context.strokeStyle = colour.good;
  context.lineWidth = 2.5 * px;
  stroke(context, right, left);
  onScreen(context, () => {
    const [x, y] = freePlace(view, run, right, left);
    label(context, x, y, `gap ${width.toFixed(2)} m`, colour.good);
  });
}

const LABEL_PX = { half: 45, high: 16, off: 10 }; // half the width of a gap's label with a robot's number; how high; how far off

/** Where the label of a gap stands on no robot: by its middle or, failing that, beyond an end. @param {View} view @param {Run} run @param {number[]} right @param {number[]} left @returns {number[]} px */
function freePlace(view, run, right, left) {
  const [one, other] = [view.toScreen(right[0], right[1]), view.toScreen(left[0], left[1])];
  const [x, y] = [(one[0] + other[0]) / 2, (one[1] + other[1]) / 2];
  const beyond = [one, other].map(([px, py]) => [px + LABEL_PX.half * Math.sign(px - x), py + LABEL_PX.high * Math.sign(py - y)]);
  const places = [[x, y - LABEL_PX.off], [x, y + LABEL_PX.off + 4], ...beyond];
  const robots = [...run.bodies.values()].map((body) => view.toScreen(body.x, body.y));
  const isFree = (/** @type {number[]} */ [px, py]) =>
    robots.every(([rx, ry]) => Math.abs(rx - px) > LABEL_PX.half || Math.abs(ry - py) > LABEL_PX.high);
  return places.find(isFree) ?? places[0];
}

/** The heading of a step, up to its target. @param {CanvasRenderingContext2D} context @param {number} px @param {[number, number]} from @param {[number, number]} to */
function drawHeading(context, px, from, to) {
  const heading = Math.atan2(to[1] - from[1], to[0] - from[0]);
  context.strokeStyle = context.fillStyle = colour.promise;
  context.lineWidth = 1.75 * px;
  stroke(context, from, to);
  context.beginPath();
  context.moveTo(to[0], to[1]);
  for (const side of [-1, 1]) {
    const back = heading + Math.PI + side * 0.4;
    context.lineTo(to[0] + 9 * px * Math.cos(back), to[1] + 9 * px * Math.sin(back));
  }
  context.fill();
}

const CHECKED_S = 1.5; // a segment that is not clear is checked again every second

/** Segments that the robots behind the leader have found not clear. @param {Scene} scene */
function drawBlocked({ context, view, run, t, px }) {
  const checks = run.kind("segment.checked");
  for (const body of run.bodies.values()) {
    const row = run.lookup("segment.checked", body.robot).at(t);
    if (row < 0 || checks.clear[row] || t - checks.t[row] > CHECKED_S) continue;
    const [x, y] = checks.target[row];
    context.strokeStyle = colour.bad;
    context.lineWidth = 2 * px;
    context.setLineDash([2 * px, 3 * px]);
    stroke(context, [body.x, body.y], [x, y]);
    context.setLineDash([]);
    onScreen(context, () =>
      label(context, ...view.toScreen(x, y), `✕ ${checks.clearance_m[row].toFixed(2)} m`, colour.bad),
    );
  }
}

/** @param {Scene} scene */
function drawLinks({ context, run, t, px, strand }) {
  if (!strand) return;
  for (let place = 1; place < strand.order.length; place++) {
    const [one, other] = [run.body(strand.order[place - 1]), run.body(strand.order[place])];
    const state = linkAt(run, one.robot, other.robot, t) || "up";
    context.strokeStyle = state === "up" ? colour.soft : colour.bad;
    context.lineWidth = (state === "up" ? 1 : 1.75) * px;
    context.setLineDash(state === "up" ? [] : [4 * px, 4 * px]);
    stroke(context, [one.x, one.y], [other.x, other.y]);
    context.setLineDash([]);
    const [x, y] = [(one.x + other.x) / 2, (one.y + other.y) / 2];
    if (state === "silent") circle(context, x, y, 5 * px);
    if (state === "broken") {
      stroke(context, [x - 5 * px, y - 5 * px], [x + 5 * px, y + 5 * px]);
      stroke(context, [x - 5 * px, y + 5 * px], [x + 5 * px, y - 5 * px]);
    }
  }
}

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {number} radius */
function circle(context, x, y, radius) {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.stroke();
}

/** Draw in pixels for once. @param {CanvasRenderingContext2D} context @param {() => void} draw */
function onScreen(context, draw) {
  const ratio = window.devicePixelRatio || 1;
  context.save();
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  draw();
  context.restore();
}

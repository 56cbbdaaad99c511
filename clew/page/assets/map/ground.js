// What never changes on a map: the grid, the bounds, the obstacles and the goal; and the moving obstacles.

/** The outline of a shape of the scenario. @param {any} shape @returns {Outline} */
function outlineOf(shape) {
  const outline = new Outline();
  if (shape.shape === "circle") {
    const [x, y] = shape.centre_m;
    outline.arc(x, y, shape.radius_m, 0, 2 * Math.PI);
  } else if (shape.shape === "ellipse") {
    const [[x, y], [a, b]] = [shape.centre_m, shape.semi_axes_m];
    outline.ellipse(x, y, a, b, shape.rotation_rad ?? 0, 0, 2 * Math.PI);
  } else {
    for (const [x, y] of shape.vertices_m) outline.lineTo(x, y);
    outline.closePath();
  }
  return outline;
}

/** @param {CanvasRenderingContext2D} context @param {View} view */
function drawGrid(context, view) {
  const step = roundStep(view.width / view.scale, 10);
  const [left, top] = view.toWorld(0, 0);
  const [right, bottom] = view.toWorld(view.width, view.height);
  context.strokeStyle = colour.rule;
  context.lineWidth = 1;
  context.beginPath();
  for (let x = Math.ceil(left / step) * step; x <= right; x += step) {
    const px = Math.round(view.toScreen(x, 0)[0]) + 0.5;
    context.moveTo(px, 0);
    context.lineTo(px, view.height);
  }
  for (let y = Math.ceil(bottom / step) * step; y <= top; y += step) {
    const py = Math.round(view.toScreen(0, y)[1]) + 0.5;
    context.moveTo(0, py);
    context.lineTo(view.width, py);
  }
  context.stroke();
}

/** How long a metre is, in the corner. @param {CanvasRenderingContext2D} context @param {View} view */
function drawScale(context, view) {
  const step = roundStep(view.width / view.scale, 8);
  const px = step * view.scale;
  const [x, y] = [16, view.height - 16];
  context.strokeStyle = context.fillStyle = colour.soft;
  context.lineWidth = 1.5;
  context.beginPath();
  context.moveTo(x, y - 4);
  context.lineTo(x, y);
  context.lineTo(x + px, y);
  context.lineTo(x + px, y - 4);
  context.stroke();
  context.font = font(11);
  context.textAlign = "center";
  context.textBaseline = "bottom";
  context.fillText(step >= 1 ? `${step} m` : `${Math.round(step * 1000)} mm`, x + px / 2, y - 3);
}

/** @param {CanvasRenderingContext2D} context @param {View} view @param {Run} run */
function drawGround(context, view, run) {
  drawGrid(context, view);
  context.save();
  view.apply(context);
  const bounds = run.scenario.bounds;
  context.strokeStyle = colour["solid-edge"];
  context.lineWidth = 1.5 / view.scale;
  if (bounds) {
    context.strokeRect(
      bounds.x_m_min,
      bounds.y_m_min,
      bounds.x_m_max - bounds.x_m_min,
      bounds.y_m_max - bounds.y_m_min,
    );
  }
  context.fillStyle = colour.solid;
  for (const shape of run.scenario.obstacle) {
    const outline = outlineOf(shape);
    context.fill(outline);
    context.stroke(outline);
  }
  context.restore();
  nameObstacles(context, view, run.scenario.obstacle);
  if (run.scenario.goal) drawGoal(context, view, run.scenario.goal);
  drawScale(context, view);
}

const NAME_PX_MIN = 5; // half of the least room for an obstacle's number

/** Numbers on the obstacles that have room for them. @param {CanvasRenderingContext2D} context @param {View} view @param {any[]} shapes */
function nameObstacles(context, view, shapes) {
  context.fillStyle = colour.soft;
  context.textAlign = "center";
  context.textBaseline = "middle";
  shapes.forEach((shape, i) => {
    const { x, y, room } = middleOf(shape);
    const [px, py] = view.toScreen(x, y);
    if (!(room * view.scale > NAME_PX_MIN) || px < 0 || py < 0 || px > view.width || py > view.height) return;
    context.font = font(Math.min(1.6 * room * view.scale, 11), "600");
    context.fillText(String(i + 1), px, py);
  });
}

/** @param {CanvasRenderingContext2D} context @param {View} view @param {any} goal */
function drawGoal(context, view, goal) {
  const [x, y] = view.toScreen(goal.at_m[0], goal.at_m[1]);
  context.strokeStyle = context.fillStyle = colour.ink;
  context.lineWidth = 1.25;
  context.setLineDash([3, 3]);
  context.beginPath();
  context.arc(x, y, Math.max((goal.tolerance_m ?? 0) * view.scale, 6), 0, 2 * Math.PI);
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  context.moveTo(x, y + 6);
  context.lineTo(x, y - 12);
  context.lineTo(x + 11, y - 8);
  context.lineTo(x, y - 4);
  context.stroke();
  context.fill();
}

/** Where a moving obstacle is on its track. @param {number[][]} track @param {number} t @returns {[number, number]} */
function placeOnTrack(track, t) {
  let i = 0;
  while (i + 1 < track.length && track[i + 1][0] <= t) i++;
  const [start, end] = [track[i], track[Math.min(i + 1, track.length - 1)]];
  const span = end[0] - start[0];
  const share = span > 0 ? Math.min(Math.max((t - start[0]) / span, 0), 1) : 0;
  return [start[1] + share * (end[1] - start[1]), start[2] + share * (end[2] - start[2])];
}

/** Moving obstacles bear their tracks. @param {CanvasRenderingContext2D} context @param {View} view @param {Run} run @param {number} t */
function drawMovers(context, view, run, t) {
  for (const mover of run.scenario.moving) {
    const { track } = mover;
    const [x, y] = placeOnTrack(track, t);
    context.save();
    view.apply(context);
    context.lineWidth = 1 / view.scale;
    context.strokeStyle = colour.faint;
    context.setLineDash([2 / view.scale, 4 / view.scale]);
    context.beginPath();
    for (const [, at, up] of track) context.lineTo(at, up);
    context.stroke();
    context.setLineDash([]);
    context.translate(x, y);
    const outline = outlineOf(mover.shape === "circle" ? { ...mover, centre_m: [0, 0] } : mover);
    context.fillStyle = colour.solid;
    context.strokeStyle = colour.ink;
    context.lineWidth = 1.5 / view.scale;
    context.fill(outline);
    context.setLineDash([5 / view.scale, 3 / view.scale]);
    context.stroke(outline);
    context.restore();
    label(context, ...view.toScreen(x, y), String(mover.id ?? ""), colour.soft);
  }
}

/** A word that is never cut by the edge. @param {CanvasRenderingContext2D} context @param {number} x px @param {number} y px @param {string} text @param {string} tone */
function label(context, x, y, text, tone) {
  context.font = font(11, "600");
  const ratio = window.devicePixelRatio || 1;
  const half = context.measureText(text).width / 2 + 3;
  x = Math.min(Math.max(x, half), context.canvas.width / ratio - half);
  y = Math.min(Math.max(y, 8), context.canvas.height / ratio - 8);
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineWidth = 3;
  context.lineJoin = "round";
  context.strokeStyle = colour.card;
  context.strokeText(text, x, y);
  context.fillStyle = tone;
  context.fillText(text, x, y);
}

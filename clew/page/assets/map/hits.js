// What is at a place of a map, in words.

const REACH_PX = 6; // how near the pointer must be to what is thin

/** @param {Pane} pane @param {number} px @param {number} py */
function sayMap(pane, px, py) {
  const { run, app, view } = pane;
  const t = app.timeOf(pane.index);
  const [x, y] = view.toWorld(px, py);
  const reach = REACH_PX / view.scale;
  const strand = strandAt(run, t);
  run.goTo(t);
  const robot = pane.robotAt(px, py);
  if (robot) return robotNow(run, run.body(robot), strand, t).split(" · ").join("\n");
  return (
    (app.layers.has("sight") && sayGap(run, strand, t, x, y, reach)) ||
    (app.layers.has("links") && sayLink(run, strand, t, x, y, reach)) ||
    sayObstacle(run, t, x, y) ||
    (run.scenario.goal && Math.hypot(x - run.scenario.goal.at_m[0], y - run.scenario.goal.at_m[1]) < Math.max(run.scenario.goal.tolerance_m ?? 0, 2 * reach)
      ? `goal, reached within ${metres(run.scenario.goal.tolerance_m ?? 0, 2)}`
      : `x ${x.toFixed(2)} m, y ${y.toFixed(2)} m`)
  );
}

/** @param {Run} run @param {any} strand @param {number} t @param {number} x @param {number} y @param {number} reach */
function sayGap(run, strand, t, x, y, reach) {
  const row = strand ? run.lookup("step.planned", strand.order[0]).at(t) : -1;
  if (row < 0) return "";
  const { gaps, ends, gap, step } = run.kind("step.planned");
  const at = ends[row].findIndex((/** @type {any} */ each) => each && toEdges([each[0], each[1]], x, y) < reach);
  if (at < 0) return "";
  const state = at === gap[row] ? "chosen" : gaps[row][at].passable ? "passable" : "not passable";
  return `gap ${metres(gaps[row][at].width_m, 2)} wide, ${state} in step ${step[row]}`;
}

/** @param {Run} run @param {any} strand @param {number} t @param {number} x @param {number} y @param {number} reach */
function sayLink(run, strand, t, x, y, reach) {
  for (let place = 1; place < (strand?.order.length ?? 0); place++) {
    const [one, other] = [run.body(strand.order[place - 1]), run.body(strand.order[place])];
    if (!(toEdges([[one.x, one.y], [other.x, other.y]], x, y) < reach)) continue;
    return `link ${one.robot}–${other.robot}: ${linkWords(run, one.robot, other.robot, t)}`;
  }
  return "";
}

const scratch = /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));

/** @param {Run} run @param {number} t @param {number} x @param {number} y */
function sayObstacle(run, t, x, y) {
  for (const mover of run.scenario.moving) {
    const [there, up] = placeOnTrack(mover.track, t);
    const outline = outlineOf(mover.shape === "circle" ? { ...mover, centre_m: [0, 0] } : mover);
    if (scratch.isPointInPath(outline, x - there, y - up)) return `moving obstacle ${mover.id ?? ""}`;
  }
  const place = run.scenario.obstacle.findIndex((/** @type {any} */ shape) => scratch.isPointInPath(outlineOf(shape), x, y));
  if (place < 0) return "";
  const shape = run.scenario.obstacle[place];
  const said = `obstacle ${place + 1}: ${shape.shape}${shape.radius_m ? `, radius ${metres(shape.radius_m, 2)}` : ""}`;
  let [who, least] = [0, Infinity];
  for (const body of run.bodies.values()) {
    const far = toEdges([...ringOf(shape), ringOf(shape)[0]], body.x, body.y) - run.radius;
    if (far < least) [who, least] = [body.robot, far];
  }
  return who ? `${said}\nnearest robot: r${who}, ${metres(least, 2)}` : said;
}

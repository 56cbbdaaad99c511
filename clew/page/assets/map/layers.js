// What a map shows of a moment, in layers that can be switched off. Each draws in metres, y up.

/**
 * @typedef {{context: CanvasRenderingContext2D, view: View, run: Run, t: number, px: number, robot: number,
 *   sees: number, plans: number, strand: any}} Scene `px`: the length of a pixel; `robot`: the chosen one, 0: none;
 *   `sees`: whose scan is shown; `plans`: whose newest step
 * @typedef {{id: string, name: string, about: string, draw: (scene: Scene) => void}} Layer
 */

/** @type {Layer[]} in the order in which they are drawn */
const LAYERS = [
  { id: "scan", name: "Scan", about: "the newest scan of the chosen robot or of the leader", draw: drawScan },
  {
    id: "promise",
    name: "Promise",
    about: "the certified ground of a step: the disc of radius r + ε swept along it",
    draw: drawPromises,
  },
  { id: "path", name: "Path", about: "the strand's path, as far as planned", draw: drawPath },
  { id: "trails", name: "Trails", about: "the way that each robot has driven", draw: drawTrails },
  {
    id: "authority",
    name: "Authority",
    about: "the movement authority of each robot: how far along the path it may drive",
    draw: drawAuthorities,
  },
  {
    id: "sight",
    name: "Sight",
    about: "tangent points, gaps, the chosen gap and the heading of the newest step",
    draw: drawSight,
  },
  {
    id: "blocked",
    name: "Blocked",
    about: "the next segment of a following robot, if it is not clear",
    draw: drawBlocked,
  },
  {
    id: "links",
    name: "Links",
    about: "links of the strand: up, silent (dashed), broken (crossed)",
    draw: drawLinks,
  },
  { id: "halos", name: "Halos", about: "the required clearance ε around each robot", draw: drawHalos },
];

/** @param {Scene} scene */
function drawScan({ context, run, t, px, sees }) {
  const row = run.lookup("scan.served", sees).at(t);
  if (row < 0) return;
  const scans = run.kind("scan.served");
  const ranges = scans.ranges_m[row];
  if (ranges.length === 0) return;
  const [x, y] = [scans.x_m[row], scans.y_m[row]];
  const limit =
    ranges.reduce((/** @type {number} */ most, /** @type {number} */ each) => Math.max(most, each), 0) -
    0.002;
  context.beginPath();
  const hits = new Outline();
  for (let ray = 0; ray < ranges.length; ray++) {
    const bearing = -Math.PI + (2 * Math.PI * ray) / ranges.length;
    const [hx, hy] = [x + ranges[ray] * Math.cos(bearing), y + ranges[ray] * Math.sin(bearing)];
    context.lineTo(hx, hy);
    if (ranges[ray] < limit) hits.rect(hx - px, hy - px, 2 * px, 2 * px);
  }
  context.closePath();
  context.globalAlpha = 0.09;
  context.fillStyle = colour.scan;
  context.fill();
  context.globalAlpha = 0.35;
  context.strokeStyle = colour.scan;
  context.lineWidth = 0.75 * px;
  context.stroke();
  context.globalAlpha = 1;
  context.fillStyle = colour.scan;
  context.fill(hits);
}

const PROMISES_SHOWN = 60; // of earlier steps: what lies further back is covered by later ones

/** @param {Scene} scene */
function drawPromises(scene) {
  const { context, run, t, px } = scene;
  const steps = run.kind("step.planned");
  const keep = run.radius + run.epsilon;
  const newest = placeAt(steps.t ?? [], (steps.t ?? []).length, t);
  context.fillStyle = colour.promise;
  context.globalAlpha = 0.07;
  for (let row = Math.max(newest - PROMISES_SHOWN, 0); row <= newest; row++) {
    context.fill(capsule([steps.x_m[row], steps.y_m[row]], pair(steps.target[row]), keep));
  }
  for (const robot of run.bodies.keys()) {
    const row = activeStep(run, robot, t);
    if (row < 0) continue;
    const ground = capsule([steps.x_m[row], steps.y_m[row]], pair(steps.target[row]), keep);
    context.globalAlpha = 0.16;
    context.fill(ground);
    context.globalAlpha = 0.9;
    context.strokeStyle = colour.promise;
    context.lineWidth = 1.25 * px;
    context.setLineDash(robot === scene.strand?.order[0] ? [] : [4 * px, 3 * px]);
    context.stroke(ground);
    context.setLineDash([]);
  }
  context.globalAlpha = 1;
}

/** The step that a robot is driving; -1: none. @param {Run} run @param {number} robot @param {number} t */
function activeStep(run, robot, t) {
  const row = run.lookup("step.planned", robot).at(t);
  if (row < 0 || !isObeyed(run, robot, row, t)) return -1;
  const steps = run.kind("step.planned");
  if (!steps.joins[row]) {
    const { end, to } = run.steps.findLast((each) => each.from <= t && each.row.robot === robot) ?? {};
    if ((end === "finished" || end === "abandoned") && Number(to) <= t) return -1;
  }
  const body = run.body(robot);
  const [x, y] = pair(steps.target[row]);
  return Math.hypot(body.x - x, body.y - y) > 0.005 ? row : -1; // one that joins records no end of its step
}

/** @param {any} point as a pair @returns {[number, number]} */
function pair(point) {
  return [point[0], point[1]];
}

/** A disc swept straight. @param {[number, number]} start @param {[number, number]} end @param {number} radius */
function capsule(start, end, radius) {
  const heading = Math.atan2(end[1] - start[1], end[0] - start[0]);
  const ground = new Outline();
  ground.arc(end[0], end[1], radius, heading - Math.PI / 2, heading + Math.PI / 2);
  ground.arc(start[0], start[1], radius, heading + Math.PI / 2, heading + 1.5 * Math.PI);
  ground.closePath();
  return ground;
}

/** @param {Scene} scene */
function drawPath({ context, run, t, px, strand }) {
  const path = strand && run.paths.get(strand.epoch);
  if (!path) return;
  const row = run.lookup("step.planned", strand.order[0]).at(t);
  const steps = run.kind("step.planned");
  const formed = run.kind("strand.formed");
  const began = formed.epoch?.indexOf(strand.epoch) ?? -1;
  const isOfStrand = row >= 0 && steps.epoch[row] === strand.epoch && !steps.joins[row];
  const end = isOfStrand ? steps.reach_m[row] : began >= 0 ? formed.places_m[began][0] : Infinity;
  context.strokeStyle = colour.soft;
  context.lineWidth = 1 * px;
  context.setLineDash([1 * px, 3 * px]);
  tracePath(context, path, 0, end);
  context.stroke();
  context.setLineDash([]);
}

/** @param {Scene} scene */
function drawTrails({ context, run, px, robot }) {
  context.lineJoin = "round";
  for (const body of run.bodies.values()) {
    context.strokeStyle = colourOf(body.robot);
    context.globalAlpha = robot === 0 ? 0.55 : robot === body.robot ? 0.95 : 0.2;
    context.lineWidth = (robot === body.robot ? 2 : 1.25) * px;
    body.strokeTrail(context); // without dashes, which take ten times as long on a long way
  }
  context.globalAlpha = 1;
}

/** @param {Scene} scene */
function drawAuthorities({ context, run, t, px, strand, robot }) {
  const path = strand && run.paths.get(strand.epoch);
  if (!path) return;
  for (let place = 1; place < strand.order.length; place++) {
    const body = run.body(strand.order[place]);
    const authority = authorityAt(run, strand, place, t);
    const progress = progressAt(run, body, strand, t, body.x, body.y);
    if (!(authority > progress)) continue;
    context.strokeStyle = colourOf(body.robot);
    context.globalAlpha = robot === 0 || robot === body.robot ? 0.45 : 0.12;
    context.lineWidth = 6 * px;
    tracePath(context, path, progress, authority);
    context.stroke();
    context.globalAlpha = 1;
    const [x, y] = pointAt(path, authority);
    const [bx, by] = pointAt(path, Math.max(authority - 0.01, 0));
    const across = Math.atan2(y - by, x - bx) + Math.PI / 2;
    context.lineWidth = 2.5 * px;
    context.beginPath();
    context.moveTo(x - 6 * px * Math.cos(across), y - 6 * px * Math.sin(across));
    context.lineTo(x + 6 * px * Math.cos(across), y + 6 * px * Math.sin(across));
    context.stroke();
  }
}

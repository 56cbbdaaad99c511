// How near a hull is to what moves, at a time; what stands still is in the log's curves.

/** What must be known before a promise can be spoken of. */
const NOT_KNOWN = "not known";

/**
 * From a hull at a place to the nearest moving obstacle [m]; infinite where nothing moves.
 * @param {Run} run @param {number} x @param {number} y @param {number} t
 */
function fromMovers(run, x, y, t) {
  let least = Infinity;
  for (const mover of run.scenario.moving) {
    const [there, up] = placeOnTrack(mover.track, t);
    const apart =
      mover.shape === "circle"
        ? Math.hypot(x - there, y - up) - mover.radius_m
        : fromRing(mover.vertices_m, x - there, y - up);
    least = Math.min(least, apart - run.radius);
  }
  return least;
}

/** From a place to a polygon; 0 inside. @param {number[][]} ring @param {number} x @param {number} y */
function fromRing(ring, x, y) {
  return isInside(ring, x, y) ? 0 : toEdges([...ring, ring[0]], x, y);
}

/** Of the robots that live, the one that is nearest to any obstacle. @param {Run} run @param {number} t */
function nearestNow(run, t) {
  let [who, least, isMoving] = [0, Infinity, false];
  for (const body of run.bodies.values()) {
    if (stateAt(run.lanes.get(body.robot), t) === "dead") continue;
    body.goTo(t);
    const [still, moving] = [body.clearance.at(t), fromMovers(run, body.x, body.y, t)];
    if (still < least) [who, least, isMoving] = [body.robot, still, false];
    if (moving < least) [who, least, isMoving] = [body.robot, moving, true];
  }
  if (!who) return "";
  if (least <= 0 && isMoving) return `robot ${who} is in contact with a moving obstacle`;
  return `nearest to ${isMoving ? "a moving" : "an"} obstacle: robot ${who}, ${metres(least, 3)} clear`;
}

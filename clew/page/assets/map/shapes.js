// Shapes of a scenario as geometry: their outlines, how far it is to them, and the middle of what they cover.

const ROUND = 72; // corners of what is round: within 0.1 % of its radius

/** The corners of a shape's outline. @param {any} shape @returns {[number, number][]} */
function ringOf(shape) {
  if (shape.shape === "polygon") return shape.vertices_m;
  const [a, b] = shape.semi_axes_m ?? [shape.radius_m, shape.radius_m];
  const [cos, sin] = [Math.cos(shape.rotation_rad ?? 0), Math.sin(shape.rotation_rad ?? 0)];
  return Array.from({ length: ROUND }, (_, i) => {
    const [u, v] = [a * Math.cos((2 * Math.PI * i) / ROUND), b * Math.sin((2 * Math.PI * i) / ROUND)];
    return [shape.centre_m[0] + u * cos - v * sin, shape.centre_m[1] + u * sin + v * cos];
  });
}

/** From a place to the nearest point of a line through corners. @param {number[][]} corners @param {number} x @param {number} y */
function toEdges(corners, x, y) {
  let least = Infinity;
  for (let i = 1; i < corners.length; i++) {
    const [[fromX, fromY], [toX, toY]] = [corners[i - 1], corners[i]];
    const [alongX, alongY] = [toX - fromX, toY - fromY];
    const length2 = alongX * alongX + alongY * alongY || 1;
    const share = Math.min(Math.max(((x - fromX) * alongX + (y - fromY) * alongY) / length2, 0), 1);
    least = Math.min(least, Math.hypot(x - fromX - share * alongX, y - fromY - share * alongY));
  }
  return least;
}

/** @param {number[][]} ring @param {number} x @param {number} y */
function isInside(ring, x, y) {
  let inside = false;
  ring.forEach(([toX, toY], i) => {
    const [fromX, fromY] = ring[(i || ring.length) - 1];
    if (toY > y !== fromY > y && x < fromX + ((toX - fromX) * (y - fromY)) / (toY - fromY)) inside = !inside;
  });
  return inside;
}

/** @type {WeakMap<any, {x: number, y: number, room: number}>} */
const middles = new WeakMap();
const TRIES = 24; // places looked at along each side of a shape's box

/** The place in a shape that is furthest from its edges, so that a word there stands on it. @param {any} shape */
function middleOf(shape) {
  let best = middles.get(shape);
  if (best) return best;
  best = { x: 0, y: 0, room: 0 };
  if (shape.shape !== "polygon") {
    const [x, y] = shape.centre_m;
    best = { x, y, room: shape.radius_m ?? Math.min(...shape.semi_axes_m) };
  } else {
    const ring = ringOf(shape);
    const box = { left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity };
    for (const [x, y] of ring) widen(box, x, y, 0);
    for (let i = 0; i < TRIES * TRIES; i++) {
      const x = box.left + (((i % TRIES) + 0.5) / TRIES) * (box.right - box.left);
      const y = box.bottom + ((Math.floor(i / TRIES) + 0.5) / TRIES) * (box.top - box.bottom);
      const room = isInside(ring, x, y) ? toEdges([...ring, ring[0]], x, y) : 0;
      if (room > best.room) best = { x, y, room };
    }
  }
  middles.set(shape, best);
  return best;
}

// The view of a map: which part of the world is seen, and how large.

class View {
  constructor() {
    this.scale = 100; // px per m
    this.x = 0; // the middle [m; world frame]
    this.y = 0;
    this.width = 1;
    this.height = 1;
    this.isFitted = true;
  }

  /** @param {{left: number, right: number, bottom: number, top: number}} box [m; world frame] */
  fit(box) {
    const margin = 14;
    const across = Math.max(box.right - box.left, 0.1);
    const up = Math.max(box.top - box.bottom, 0.1);
    this.scale = Math.min((this.width - 2 * margin) / across, (this.height - 2 * margin) / up);
    this.x = (box.left + box.right) / 2;
    this.y = (box.bottom + box.top) / 2;
  }

  /** Have a canvas take metres, y up. @param {CanvasRenderingContext2D} context */
  apply(context) {
    const ratio = window.devicePixelRatio || 1;
    const s = this.scale * ratio;
    context.setTransform(
      s,
      0,
      0,
      -s,
      (this.width / 2) * ratio - this.x * s,
      (this.height / 2) * ratio + this.y * s,
    );
  }

  /** @param {number} x @param {number} y @returns {[number, number]} px */
  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  /** @param {number} px @param {number} py @returns {[number, number]} [m; world frame] */
  toWorld(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  /** @param {number} factor @param {number} px what stays in its place @param {number} py */
  zoom(factor, px, py) {
    const [x, y] = this.toWorld(px, py);
    this.scale = Math.min(Math.max(this.scale * factor, 0.5), 20000);
    this.x = x - (px - this.width / 2) / this.scale;
    this.y = y + (py - this.height / 2) / this.scale;
    this.isFitted = false;
  }

  /** @param {number} dx px @param {number} dy px */
  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
    this.isFitted = false;
  }
}

/** The part of the world in which a run happens. @param {Run} run */
function boxOf(run) {
  const bounds = run.scenario.bounds;
  if (bounds)
    return { left: bounds.x_m_min, right: bounds.x_m_max, bottom: bounds.y_m_min, top: bounds.y_m_max };
  const box = { left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity };
  for (const body of run.bodies.values()) {
    for (let i = 0; i < body.t.length; i++)
      widen(box, body.xs.data[i], body.ys.data[i], run.radius + run.epsilon);
  }
  for (const shape of run.scenario.obstacle) {
    for (const [x, y, reach] of extentsOf(shape)) widen(box, x, y, reach);
  }
  const goal = run.scenario.goal;
  if (goal) widen(box, goal.at_m[0], goal.at_m[1], goal.tolerance_m ?? 0);
  return box.left < box.right ? box : { left: -1, right: 1, bottom: -1, top: 1 };
}

/** The same for several runs. @param {Run[]} runs */
function boxOfAll(runs) {
  const [first, ...others] = runs.map(boxOf);
  for (const { left, right, bottom, top } of others) {
    widen(first, left, bottom, 0);
    widen(first, right, top, 0);
  }
  return first;
}

/** @param {{left: number, right: number, bottom: number, top: number}} box @param {number} x @param {number} y @param {number} by */
function widen(box, x, y, by) {
  box.left = Math.min(box.left, x - by);
  box.right = Math.max(box.right, x + by);
  box.bottom = Math.min(box.bottom, y - by);
  box.top = Math.max(box.top, y + by);
}

/** Places that a shape lies round, with how far. @param {any} shape @returns {[number, number, number][]} */
function extentsOf(shape) {
  if (shape.shape === "polygon") return shape.vertices_m.map((/** @type {number[]} */ [x, y]) => [x, y, 0]);
  const reach = shape.shape === "circle" ? shape.radius_m : Math.max(...shape.semi_axes_m);
  return [[shape.centre_m[0], shape.centre_m[1], reach]];
}

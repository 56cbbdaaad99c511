// What of a run's scenario can be drawn. It stands in the log as it was written, by whatever version, or by hand.

/** @param {any} value */
function isNumber(value) {
  return typeof value === "number" && Number.isFinite(value);
}

/** @param {any} value @param {number} length of each of its rows @returns {boolean} */
function areRows(value, length) {
  return (
    Array.isArray(value) &&
    value.every((row) => Array.isArray(row) && row.length >= length && row.every(isNumber))
  );
}

const NOTHING = { shape: "polygon", vertices_m: [] };

/** A shape that can be drawn; what cannot becomes one of no extent, so that the others keep their numbers. @param {any} shape */
function drawable(shape) {
  switch (shape?.shape) {
    case "circle":
      return areRows([shape.centre_m], 2) && isNumber(shape.radius_m) ? shape : NOTHING;
    case "ellipse":
      return areRows([shape.centre_m, shape.semi_axes_m], 2) ? shape : NOTHING;
    case "polygon":
      return areRows(shape.vertices_m, 2) ? shape : NOTHING;
    default:
      return NOTHING;
  }
}

/** @param {any} mover */
function canMove(mover) {
  const outline = mover?.shape === "circle" ? { ...mover, centre_m: [0, 0] } : mover;
  return areRows(mover?.track, 3) && mover.track.length > 0 && drawable(outline) !== NOTHING;
}

/** A scenario of which everything that is there can be drawn. @param {any} said */
function sound(said) {
  const bounds = Object.values(said?.bounds ?? {});
  return {
    ...said,
    obstacle: (Array.isArray(said?.obstacle) ? said.obstacle : []).map(drawable),
    moving: (Array.isArray(said?.moving) ? said.moving : []).filter(canMove),
    bounds: bounds.length === 4 && bounds.every(isNumber) ? said.bounds : null,
    goal: areRows([said?.goal?.at_m], 2) ? said.goal : null,
    table_m: areRows(said?.table_m, 1) ? said.table_m : null,
  };
}

// The legend of a map: a small picture of each sign, and its name.

/** @type {[string, string][]} SVG of 34 by 16 px, in the colours of the theme; what it means */
const LEGEND = [
  ['<circle cx="14" cy="8" r="6" fill="var(--ink)"/><path d="M20 8h5" stroke="var(--ink)" stroke-width="2.5"/>', "robot, with a tick ahead"],
  ['<circle cx="17" cy="8" r="4.5" fill="var(--ink)"/><circle cx="17" cy="8" r="7" fill="none" stroke="var(--ink)" stroke-width="1.5"/>', "leader"],
  ['<circle cx="17" cy="8" r="6" fill="none" stroke="var(--bad)" stroke-width="2"/><path d="M13 4l8 8M13 12l8-8" stroke="var(--bad)" stroke-width="1.5"/>', "dead"],
  ['<circle cx="17" cy="8" r="7" fill="none" stroke="var(--ink)" stroke-dasharray="3 2.5"/>', "halo: ε round the hull"],
  ['<rect x="1" y="2" width="32" height="12" rx="6" fill="var(--promise)" fill-opacity=".16" stroke="var(--promise)"/>', "certified ground of a step"],
  ['<path d="M0 8h28" stroke="var(--ink)" stroke-opacity=".45" stroke-width="6"/><path d="M28 2v12" stroke="var(--ink)" stroke-width="2.5"/>', "authority, up to its end"],
  ['<path d="M0 8h34" stroke="var(--soft)" stroke-dasharray="1 3"/>', "path of the strand"],
  ['<path d="M0 12q17-14 34-4" fill="none" stroke="var(--ink)" stroke-opacity=".55" stroke-width="1.25"/>', "trail of a robot"],
  ['<path d="M4 8h26" stroke="var(--good)" stroke-width="2.5"/>', "chosen gap, with its width"],
  ['<path d="M4 8h26" stroke="var(--ink)" stroke-dasharray="5 3"/>', "passable gap; dotted: not"],
  ['<path d="M8 8l4-4 4 4-4 4z" fill="var(--ink)"/><path d="M12 8h18" stroke="var(--ink)"/>', "tangent points, with their chord"],
  ['<path d="M0 8h26" stroke="var(--promise)" stroke-width="1.75"/><path d="M26 4l8 4-8 4z" fill="var(--promise)"/>', "heading of the step"],
  ['<path d="M2 14L10 2l14 0 8 12z" fill="var(--scan)" fill-opacity=".2" stroke="var(--scan)"/>', "ground that was seen to be free"],
  ['<path d="M0 8h34" stroke="var(--bad)" stroke-width="1.75" stroke-dasharray="4 4"/><circle cx="17" cy="8" r="5" fill="none" stroke="var(--bad)"/>', "silent link; crossed: broken"],
  ['<circle cx="14" cy="9" r="6" fill="none" stroke="var(--ink)" stroke-dasharray="3 3"/><path d="M14 14V1l10 4-10 3" fill="var(--ink)"/>', "goal"],
];

function fillLegend() {
  byId("legend").replaceChildren(
    ...LEGEND.map(([sign, name]) => {
      const row = element("span", {}, name);
      row.insertAdjacentHTML("afterbegin", `<svg viewBox="0 0 34 16" aria-hidden="true">${sign}</svg>`);
      return row;
    }),
  );
}

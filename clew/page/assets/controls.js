// The page's controls: buttons, layers, theme, help, and the address that leads to a moment.

/** @param {App} app @param {Player} player */
function listenToControls(app, player) {
  const on = (/** @type {string} */ id, /** @type {() => void} */ act) =>
    byId(id).addEventListener("click", act);
  on("play", () => player.toggle());
  on("step-back", () => player.step(-1));
  on("step-on", () => player.step(1));
  on("live", () => app.follow());
  on("time-in", () => app.span.zoom(2, app.time));
  on("time-out", () => app.span.zoom(0.5, app.time));
  on("time-whole", () => app.span.whole());
  on("map-whole", () => (app.panes.forEach((pane) => pane.fit()), app.show()));
  on("map-robots", () => (app.panes.forEach((pane) => pane.fitRobots()), app.show()));
  on("map-watch", () => app.watch());
  on("map-legend", () => {
    byId("legend").hidden = !byId("legend").hidden;
    byId("map-legend").setAttribute("aria-pressed", String(!byId("legend").hidden));
  });
  fillLegend();
  for (const each of byId("save").querySelectorAll("button"))
    each.addEventListener("click", async () => {
      each.disabled = true; // a film takes its time
      await save(app, each.dataset.save ?? "").finally(() => (each.disabled = false));
    });
  on("theme", () => toggleTheme());
  on("help-open", () => toggleHelp());
  on("help-close", () => toggleHelp());
  const speed = /** @type {HTMLSelectElement} */ (byId("speed"));
  speed.append(...SPEEDS.map((each) => element("option", { value: String(each) }, `${each}×`)));
  speed.addEventListener("change", () => (player.speed = Number(speed.value)));
  app.onTime.push(() => {
    speed.value = String(player.speed);
    const play = byId("play");
    play.textContent = player.isPlaying ? "❚❚ Pause" : "▶ Play";
    play.setAttribute("aria-pressed", String(player.isPlaying));
    byId("live").hidden = app.run.ended;
    byId("map-watch").setAttribute("aria-pressed", String(app.isWatching));
    /** @type {HTMLButtonElement} */ (byId("time-whole")).disabled = app.span.isWhole;
    byId("live").setAttribute("aria-pressed", String(app.follows));
  });
  byId("keys").append(
    ...KEYS_HELP.map((each) =>
      element("tr", {}, element("th", { scope: "row" }, each.names), element("td", {}, each.does)),
    ),
  );
  byId("signs").append(
    ...Object.values(SIGNS)
      .filter(({ row }) => row <= 1)
      .map(({ sign, name, row }) => element("li", {}, element("i", { class: `row${row}` }, sign), ` ${name}`)),
  );
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => retheme(app));
  const beside = new ResizeObserver(() => {
    const { style } = document.documentElement; // the map takes what these leave of the screen
    style.setProperty("--timeline", `${byId("timeline").offsetHeight}px`);
    style.setProperty("--above", `${byId("panes").offsetTop}px`);
    app.show();
  });
  for (const id of ["timeline", "verdict", "flaws"]) beside.observe(byId(id));
  listenToSplitter(byId("splitter"));
  new ResizeObserver(() => app.show()).observe(byId("panes"));
  listenToLayers(app);
  listenToEntries(app);
}

/** @param {App} app */
function listenToLayers(app) {
  for (const { id, name, about } of LAYERS) {
    const chip = element(
      "button",
      { type: "button", "aria-pressed": "true", title: about, "data-layer": id },
      name,
    );
    chip.addEventListener("click", () => {
      if (!app.layers.delete(id)) app.layers.add(id);
      chip.setAttribute("aria-pressed", String(app.layers.has(id)));
      app.show();
    });
    byId("layers").append(chip);
  }
}

let themed = /** @type {App | null} */ (null);

/** @param {App} app */
function retheme(app) {
  themed = app;
  readTheme();
  app.show();
}

function toggleTheme() {
  const root = document.documentElement;
  const isDark = getComputedStyle(root).colorScheme.trim() === "dark";
  root.dataset.theme = isDark ? "light" : "dark";
  if (themed) retheme(themed);
}

function toggleHelp() {
  const help = /** @type {HTMLDialogElement} */ (byId("help"));
  if (help.open) help.close();
  else help.showModal();
}

/** Go where the address says: `#t=12.3&robot=3`. @param {App} app */
function followAddress(app) {
  const asked = new URLSearchParams(location.hash.slice(1));
  const [time, robot] = [Number(asked.get("t") ?? NaN), Number(asked.get("robot") ?? NaN)];
  if (app.run && app.run.bodies.has(robot)) app.robot = robot;
  if (app.run && Number.isFinite(time)) app.seek(time);
}

/** Keep the address at the moment that is shown, for whoever copies it. @param {App} app @param {Player} player */
function keepAddress(app, player) {
  let awaited = 0;
  app.onTime.push(() => {
    clearTimeout(awaited);
    if (player.isPlaying || app.follows) return;
    awaited = window.setTimeout(() => {
      const robot = app.robot ? `&robot=${app.robot}` : "";
      history.replaceState(null, "", `#t=${app.time.toFixed(2)}${robot}`);
    }, 300); // browsers refuse more than a hundred changes in some seconds
  });
}

const SPLIT_PX = { least: 60, most: 0.7, key: 24 }; // `most`: of the window; `key`: what an arrow key moves it by

/** Give the lanes what is above the pointer, or by keys. @param {HTMLElement} splitter */
function listenToSplitter(splitter) {
  const lanes = byId("lanes-scroll");
  const set = (/** @type {number} */ px) => {
    const height = Math.min(Math.max(px, SPLIT_PX.least), SPLIT_PX.most * window.innerHeight);
    document.documentElement.style.setProperty("--lanes", `${height}px`);
    splitter.setAttribute("aria-valuenow", height.toFixed(0));
  };
  let from = { y: 0, height: 0 };
  splitter.addEventListener("pointerdown", (event) => {
    splitter.setPointerCapture(event.pointerId);
    from = { y: event.clientY, height: lanes.offsetHeight };
  });
  splitter.addEventListener("pointermove", (event) => {
    if (splitter.hasPointerCapture(event.pointerId)) set(from.height + from.y - event.clientY);
  });
  splitter.addEventListener("dblclick", () => document.documentElement.style.removeProperty("--lanes"));
  splitter.addEventListener("keydown", (event) => {
    const by = { ArrowUp: SPLIT_PX.key, ArrowDown: -SPLIT_PX.key }[event.key];
    if (!by) return;
    event.preventDefault();
    set(lanes.offsetHeight + by);
  });
}

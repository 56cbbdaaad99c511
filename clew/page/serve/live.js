// Feeds the page from the viewer: all messages of every run, as they come.
//
// Rule 1: if the viewer is away, EventSource reconnects by itself and continues after the last message.
// Rule 2: a run that has ended sends nothing more; the viewer may then end without a notice.
// Rule 3: an address with a moment waits until the run has reached it.
// Rule 4: `anew` means that the viewer now has another run than the page: it reloads, without the moment.
"use strict";
{
  const notice = document.createElement("p");
  notice.id = "notice";
  notice.setAttribute("role", "status");
  notice.textContent = "Waiting for a run to begin.";
  document.body.prepend(notice);
  /** @type {HTMLElement} */ (document.getElementById("badge")).textContent = "… Waiting";

  /** @param {string} text empty: hide it */
  const say = (text) => {
    notice.textContent = text;
    notice.hidden = text === "";
  };

  const moment = location.hash;
  let asked = new URLSearchParams(location.hash.slice(1)).get("t");
  const land = () => {
    if (asked === null || !(clew.runs[0]?.ended || clew.runs[0]?.end >= Number(asked))) return;
    history.replaceState(null, "", moment);
    dispatchEvent(new HashChangeEvent("hashchange"));
    asked = null;
  };

  /** @param {string} path of the run's feed @param {number} run its index */
  const follow = (path, run) => {
    const events = new EventSource(path);
    let ended = false;
    events.onmessage = (message) => {
      const batch = JSON.parse(message.data);
      ended ||= batch.ended === true;
      say("");
      clew.take(run, batch);
      land();
    };
    events.onerror = () => {
      if (ended) events.close();
      else say("The viewer is away; reconnecting.");
    };
    events.addEventListener("anew", () => location.replace(location.pathname));
  };
  FEEDS.forEach(follow);
}

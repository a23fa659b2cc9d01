// Improves the page, which works without it: the live stream replaces what changes, the slider moves at once, and the
// stop has a request of its own.
"use strict";
(() => {
  const find = (id) => document.getElementById(id);
  const live = () => find("live");
  const fields = "input, textarea, select";
  let source, requests = new AbortController();
  let isRefreshing = false, isStale = false, isSending = false, changes = 0, swappedAt = 0, shown = "", progress = "";

  // The part that changes

  const keyOf = (node) => node.nodeType !== 1 ? node.nodeName
    : [node.nodeName, node.id, node.dataset.key, node.getAttribute("action"), node.getAttribute("type")].join("|");

  function copyAttributes(from, to) {
    for (const { name } of [...from.attributes]) {
      // Details that a person has opened stay open.
      if (!to.hasAttribute(name) && name !== "open") from.removeAttribute(name);
    }
    for (const { name, value } of to.attributes) {
      if (from.getAttribute(name) !== value) from.setAttribute(name, value);
    }
  }

  // The reason why a form failed stays until the next form.
  const drop = (node) => isSending || !node.matches?.(".attempt") ? node.remove() : undefined;

  // Makes an element equal to another one and keeps those that are in both, with their focus, text and position.
  function morph(from, to) {
    copyAttributes(from, to);
    if ("keep" in from.dataset && "keep" in to.dataset) {
      if (from.type === "range" && document.activeElement !== from) from.value = to.getAttribute("value");
      return;
    }
    let old = from.firstChild;
    for (const next of [...to.childNodes]) {
      let match = old;
      while (match && keyOf(match) !== keyOf(next)) match = match.nextSibling;
      if (!match) {
        from.insertBefore(next, old);
        continue;
      }
      while (old !== match) {
        const gone = old;
        old = old.nextSibling;
        drop(gone);
      }
      old = match.nextSibling;
      if (match.nodeType !== 1) {
        if (match.nodeValue !== next.nodeValue) match.nodeValue = next.nodeValue;
      } else if (!match.isEqualNode(next)) morph(match, next);
    }
    while (old) {
      const gone = old;
      old = old.nextSibling;
      drop(gone);
    }
  }

  function swap(html) {
    if (html === shown) return;
    const next = new DOMParser().parseFromString(html, "text/html").getElementById("live");
    if (!next) return;
    shown = html;
    const focused = document.activeElement;
    morph(live(), next);
    document.title = `${next.dataset.title} · Longstep`;
    swappedAt = Date.now();
    showTimes();
    showProgress();
    if (focused && focused !== document.body && !focused.isConnected) live().focus({ preventScroll: true });
  }

  async function refresh() {
    if (isRefreshing) {
      isStale = true;
      return;
    }
    isRefreshing = true;
    isStale = false;
    const before = changes;
    try {
      const path = location.pathname === "/" ? "" : location.pathname;
      const options = { headers: { Accept: "text/html" }, signal: requests.signal };
      const answer = await fetch(`${path}/fragment${location.search}`, options);
      const html = await answer.text();
      // A form that was sent meanwhile has brought something newer.
      if (answer.ok && before === changes) swap(html);
      else isStale ||= before !== changes;
    } catch { /* The live stream says so. */ }
    isRefreshing = false;
    if (isStale && !isSending) setTimeout(refresh, 100);
  }

  // The stream may be faster than the page that shows it.
  function showProgress() {
    if (progress && find("progress")) find("progress").textContent = progress;
  }

  function showTimes() {
    for (const time of document.querySelectorAll("time[datetime]")) {
      time.textContent = new Date(time.dateTime).toLocaleString();
    }
  }

  // The live stream

  // A browser has six connections to a server: a hidden page gives its one back.
  function follow() {
    source?.close();
    const follows = document.body.dataset.follows;
    if (follows === undefined || document.hidden) return;
    source = new EventSource(`/api/events${follows}`);
    source.onopen = () => {
      find("link").textContent = "";
      refresh();
    };
    source.onerror = () => {
      find("link").textContent = "The server does not answer. What you see may be old.";
      if (source.readyState === EventSource.CLOSED) setTimeout(follow, 3000);
    };
    source.addEventListener("reset", refresh);
    source.addEventListener("happened", (event) => {
      const what = JSON.parse(event.data);
      if (what.kind !== "progress") return refresh();
      progress = `The model: ${what.text} …`;
      showProgress();
    });
  }

  // Forms

  function complain(form, text) {
    const note = document.createElement("p");
    note.className = "problem attempt";
    note.setAttribute("role", "alert");
    note.textContent = text;
    form.before(note);
  }

  async function send(form) {
    isSending = true;
    changes += 1;
    progress = "";
    form.setAttribute("aria-busy", "true");
    try {
      const options = { method: "POST", body: new URLSearchParams(new FormData(form)), headers: { Accept: "text/html" } };
      const answer = await fetch(form.action, { ...options, signal: requests.signal });
      const there = new URL(answer.url);
      if (answer.redirected && there.pathname !== location.pathname) return location.assign(answer.url);
      if (answer.redirected) history.replaceState(null, "", there.pathname + there.search);
      const html = await answer.text();
      if (!html.includes('id="live"')) throw new Error(html);
      swap(html);
    } catch {
      complain(form, "The server did not answer. Look whether it was done before you send it again.");
    }
    changes += 1;
    isSending = false;
    form.removeAttribute("aria-busy");
    if (isStale) refresh();
  }

  document.addEventListener("submit", (event) => {
    const form = event.target;
    event.preventDefault();
    if (form.dataset.stop) return stop(form);
    if (form.method === "get") return look(new FormData(form).get("step"));
    // A second click of a double click is not meant for a button that has just come.
    const isHasty = event.submitter?.hasAttribute("data-guard") && Date.now() - swappedAt < 800;
    if (!isSending && !isHasty) send(form);
  });

  // The stop

  async function stop(form, tries = 1) {
    const note = find("stopped");
    note.textContent = "Sending the stop …";
    form.classList.add("sent");
    // Nothing of this page holds up the stop, not even a connection.
    source?.close();
    requests.abort();
    requests = new AbortController();
    try {
      const options = { method: "POST", keepalive: true, priority: "high", signal: AbortSignal.timeout(4000) };
      const answer = await fetch(form.dataset.stop, options);
      if (!answer.ok) throw new Error((await answer.json()).error.message);
      note.textContent = `Stop sent at ${new Date().toLocaleTimeString()}`;
    } catch (error) {
      note.textContent = `The stop failed: ${error.message}. Use the robot's own emergency stop. Trying again …`;
      if (tries < 20) setTimeout(stop, 500, form, tries + 1);
    }
    form.classList.remove("sent");
    follow();
  }

  // The picture of a step

  function look(step) {
    const there = new URL(location.href);
    there.searchParams.set("step", step);
    history.replaceState(null, "", there.pathname + there.search);
    refresh();
  }

  document.addEventListener("input", (event) => {
    if (event.target.id === "slider") look(event.target.value);
  });

  document.addEventListener("click", (event) => {
    const link = event.target.closest?.('a[href*="?step="]');
    if (!link || event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    look(new URL(link.href).searchParams.get("step"));
    find("scene")?.scrollIntoView({ block: "nearest" });
  });

  // Keys

  let hold;
  function release() {
    clearTimeout(hold);
    hold = undefined;
    find("stop")?.classList.remove("arming");
  }

  function turn(by) {
    const slider = find("slider");
    if (!slider) return;
    slider.value = Number(slider.value) + by;
    look(slider.value);
  }

  function pressEscape(event) {
    const form = document.querySelector("form[data-stop]");
    if (event.repeat || hold || !form) return;
    find("stop").classList.add("arming");
    hold = setTimeout(() => {
      release();
      stop(form);
    }, 1000);
  }

  function goToText(event) {
    const field = find("instruct") || find("answer") || find("feedback");
    if (!field || !find("letters").checked) return;
    event.preventDefault();
    field.closest("details")?.setAttribute("open", "");
    field.focus();
  }

  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape") return pressEscape(event);
    if (event.ctrlKey || event.metaKey || event.altKey || event.isComposing) return;
    if (event.target.matches?.("textarea") && event.key === "Enter" && !event.shiftKey) {
      event.preventDefault();
      return event.target.form.requestSubmit();
    }
    if (event.target.matches?.(`${fields}, .wide`)) return;
    if (event.key === "ArrowLeft") turn(-1);
    if (event.key === "ArrowRight") turn(1);
    if (event.key === "/") goToText(event);
  });
  document.addEventListener("keyup", (event) => event.key === "Escape" && release());
  addEventListener("blur", release);

  // The beginning

  document.documentElement.classList.add("scripted");
  const letters = find("letters");
  if (letters) {
    letters.checked = localStorage.getItem("letters") !== "off";
    letters.addEventListener("change", () => localStorage.setItem("letters", letters.checked ? "on" : "off"));
  }
  document.addEventListener("visibilitychange", follow);
  addEventListener("pageshow", (event) => event.persisted && refresh());
  showTimes();
  follow();
})();

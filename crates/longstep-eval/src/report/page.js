"use strict";
(() => {
  const articles = Array.from(document.querySelectorAll("article.attempt"));
  if (!articles.length || typeof HTMLDialogElement === "undefined") return;

  const dialog = document.createElement("dialog");
  dialog.setAttribute("aria-label", "An attempt");
  const nav = dialog.appendChild(document.createElement("nav"));
  const button = (text, act) => {
    const made = nav.appendChild(document.createElement("button"));
    made.type = "button";
    made.textContent = text;
    made.addEventListener("click", act);
    return made;
  };
  let shown = 0;
  const before = button("← Before", () => show(shown - 1));
  const next = button("Next →", () => show(shown + 1));
  button("Close", () => dialog.close());
  const body = dialog.appendChild(document.createElement("div"));
  body.className = "opened";
  body.tabIndex = -1;
  document.body.appendChild(dialog);

  function show(place) {
    if (place < 0 || place >= articles.length) return;
    shown = place;
    body.replaceChildren(...Array.from(articles[place].cloneNode(true).childNodes));
    before.disabled = place === 0;
    next.disabled = place === articles.length - 1;
    if (!dialog.open) dialog.showModal();
    // From here the arrow keys scroll, and a button that is disabled now does not keep the focus.
    body.focus();
    dialog.scrollTop = 0;
  }

  document.addEventListener("click", (event) => {
    const link = event.target.closest("a[href^='#attempt-']");
    if (!link || event.ctrlKey || event.metaKey || event.shiftKey) return;
    const place = articles.findIndex((article) => "#" + article.id === link.getAttribute("href"));
    if (place < 0) return;
    event.preventDefault();
    show(place);
  });
  dialog.addEventListener("click", (event) => {
    if (event.target === dialog) dialog.close();
  });
  dialog.addEventListener("keydown", (event) => {
    // Wide tables are scrolled sideways with the same keys.
    if (event.target.closest(".scroll")) return;
    if (event.key === "ArrowLeft") show(shown - 1);
    if (event.key === "ArrowRight") show(shown + 1);
  });
})();

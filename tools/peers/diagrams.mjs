// Draws plans with Mermaid in a browser and with Graphviz, and compares the two pictures: RUNNER EVERY | node diagrams.mjs BROWSER_FOLDER
//
// Both have to show the same shapes with the same lines of text, the same arrows with the same labels, and the same lanes, and every
// step of the plan. tools/peers/diagrams.sh makes the tools ready and runs this.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { createRequire } from "node:module";
import path from "node:path";
import { createInterface } from "node:readline";

const folder = path.resolve(process.argv[2]);
const require = createRequire(path.join(folder, "package.json"));
const { chromium } = require("playwright-core");
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
const page = await browser.newPage();
// Pages with Mermaid have its defaults; those of GitHub differ in nothing that is used here.
await page.addScriptTag({ path: path.join(folder, "node_modules/mermaid/dist/mermaid.min.js") });
await page.evaluate(() => globalThis.mermaid.initialize({ startOnLoad: false, securityLevel: "strict" }));

/** Draws with Mermaid, and reads the picture. */
async function drawnByMermaid(text) {
  return page.evaluate(async (source) => {
    const { svg } = await globalThis.mermaid.render("picture", source);
    document.body.innerHTML = svg;
    const lines = (element) => {
      const label = element.querySelector("foreignObject") ?? element;
      for (const end of label.querySelectorAll("br")) end.replaceWith("\n");
      return label.textContent.trim();
    };
    const number = (id) => id.match(/flowchart-(n\d+)-/)[1];
    const nodes = [...document.querySelectorAll("g.node")].map((node) => [number(node.id), lines(node)]);
    const lanes = [...document.querySelectorAll("g.cluster")].map((lane) => lines(lane.querySelector(".cluster-label")));
    const paths = [...document.querySelectorAll("path.flowchart-link")];
    const labels = new Map([...document.querySelectorAll(".edgeLabels .label[data-id]")].map((label) => [label.dataset.id, lines(label)]));
    const arrow = (own) => [...own.dataset.id.match(/^L_(n\d+)_(n\d+)_/).slice(1), labels.get(own.dataset.id) ?? ""];
    return { nodes, lanes, arrows: paths.map(arrow) };
  }, text);
}

/** Draws with Graphviz, and reads the picture. */
async function drawnByGraphviz(text) {
  const drawn = spawnSync("dot", ["-Tsvg"], { input: text, encoding: "utf8", timeout: 60_000, maxBuffer: 1 << 28 });
  assert.equal(drawn.status, 0, drawn.stderr);
  assert.equal(drawn.stderr, "");
  return page.evaluate((svg) => {
    const picture = new DOMParser().parseFromString(svg, "image/svg+xml");
    const of = (kind) => [...picture.querySelectorAll(`g.${kind}`)];
    const title = (group) => group.querySelector("title").textContent;
    const lines = (group) => [...group.querySelectorAll("text")].map((own) => own.textContent.trim()).join("\n").trim();
    return {
      nodes: of("node").map((node) => [title(node), lines(node)]),
      lanes: of("cluster").map(lines),
      arrows: of("edge").map((edge) => [...title(edge).split("->"), lines(edge)]),
    };
  }, drawn.stdout);
}

/** What both pictures show, in an order that no layout decides; each run of spaces counts as one, a word joiner as nothing. */
function content({ nodes, lanes, arrows }) {
  const plain = (text) => text.replace(/[^\S\n]+/gu, " ").replaceAll("\u2060", "");
  return {
    nodes: nodes.map(([name, text]) => `${name}: ${plain(text)}`).sort(),
    lanes: lanes.map(plain).sort(),
    arrows: arrows.map(([from, to, label]) => `${from} -> ${to} ${plain(label)}`.trim()).sort(),
  };
}

/** Fails with what only one of the pictures shows. */
function compare(name, one, other) {
  for (const kind of ["nodes", "lanes", "arrows"]) {
    const alone = (own, others) => own.filter((text) => !others.includes(text));
    const difference = { Mermaid: alone(one[kind], other[kind]), Graphviz: alone(other[kind], one[kind]) };
    const message = `${name}: different ${kind}: ${JSON.stringify(difference, null, 2).replace(/(.)\1{20,}/gu, "$1…").slice(0, 2000)}`;
    assert.ok(!difference.Mermaid.length && !difference.Graphviz.length, message);
    assert.equal(one[kind].length, other[kind].length, `${name}: some ${kind} are shown twice`);
  }
}

let plans = 0, shapes = 0, lanes = 0, longest = 0;
try {
  for await (const line of createInterface({ input: process.stdin })) {
    const { name, steps, mermaid, dot } = JSON.parse(line);
    const [one, other] = [content(await drawnByMermaid(mermaid)), content(await drawnByGraphviz(dot))];
    compare(name, one, other);
    const numbers = one.nodes.map((text) => text.match(/^n\d+: (\d+)\. /)?.[1]).filter(Boolean);
    assert.equal(new Set(numbers).size, steps, `${name}: not every step is shown`);
    plans += 1;
    shapes += one.nodes.length;
    lanes += one.lanes.length;
    longest = Math.max(longest, steps);
  }
} catch (error) {
  console.error(`error: ${error.message}`);
  process.exitCode = 1;
} finally {
  await browser.close();
}
if (!process.exitCode) {
  assert.ok(plans > 0, "there were no plans");
  console.log(`${plans} plans of up to ${longest} steps, ${shapes} shapes, ${lanes} lanes: Mermaid and Graphviz show the same`);
}

// The page in a browser, against the demo server: node page.mjs DEMO_SERVER BROWSER_FOLDER [SCREENSHOTS] [CASE]
// scripts/page.sh builds the server, makes the browser ready, and runs this.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { createInterface } from "node:readline";
import path from "node:path";

const [server, folder, shots, only] = process.argv.slice(2);
const require = createRequire(path.join(path.resolve(folder), "package.json"));
const { chromium } = require("playwright-core");
const axe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

const WIDTHS = { phone: [390, 844], laptop: [1280, 800], wall: [2560, 1440] };
const program = spawn(server, ["15"], { stdio: ["ignore", "pipe", "inherit"] });
const [link] = await new Promise((resolve) => createInterface({ input: program.stdout }).once("line", (line) => resolve([line])));
const origin = new URL(link).origin;
const token = new URL(link).searchParams.get("token");
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });

/** Opens the link in a browser of its own; every error of the page and every breach of its policy is collected. */
async function visitor(options = {}) {
  const [width, height] = WIDTHS[options.size ?? "laptop"];
  const context = await browser.newContext({
    viewport: { width, height }, colorScheme: options.scheme ?? "light", javaScriptEnabled: options.script ?? true,
  });
  context.setDefaultTimeout(10_000);
  const page = await context.newPage();
  page.faults = [];
  page.on("pageerror", (error) => page.faults.push(String(error)));
  page.on("console", (message) => {
    const text = message.text();
    const expected = /status of 4\d\d|net::ERR|EventSource/.test(text);
    if (message.type() === "error" && !expected) page.faults.push(text);
  });
  await page.goto(link);
  assert.equal(page.url(), `${origin}/`, "the address loses the token");
  return page;
}

async function leave(page) {
  assert.deepEqual(page.faults, []);
  await page.context().close();
}

/** Asks the interface for programs. */
async function api(method, place, body, headers = {}) {
  const answer = await fetch(origin + place, {
    method,
    headers: { Authorization: `Bearer ${token}`, ...(body ? { "Content-Type": "application/json" } : {}), ...headers },
    body: body && JSON.stringify(body),
  });
  return { status: answer.status, body: await answer.json() };
}

const runs = async () => (await api("GET", "/api/runs")).body.runs.length;
const idOf = (page) => new URL(page.url()).pathname.split("/")[2];

async function begin(page, scene = "pantry") {
  await page.goto(origin);
  await page.getByRole("button", { name: `Begin in ${scene}` }).click();
  await page.waitForURL(/\/sessions\//);
}

async function instruct(page, text) {
  await page.getByLabel("Say what the robot should do").fill(text);
  await page.getByRole("button", { name: "Make a plan" }).click();
}

// The policy of the page forbids to evaluate texts, which `waitForFunction` does.
const isState = (page, ...states) =>
  page.locator(states.map((state) => `#state[data-state="${state}"]`).join(", ")).waitFor();

/** Approves for a robot and starts. */
async function approveAndStart(page, robot) {
  await page.getByRole("button", { name: new RegExp(`approve for ${robot}$`) }).click();
  const start = page.getByRole("button", { name: `Start on ${robot}` });
  await start.waitFor();
  // The page takes no double click for a start.
  await page.waitForTimeout(900);
  await start.click();
  await page.waitForURL(/\/runs\//);
}

async function planned(page, text = "Put the juice on top of the shelf", scene = "pantry") {
  await begin(page, scene);
  await instruct(page, text);
  await isState(page, "plan", "consent");
}

const cases = {
  async strangers_are_told_to_open_the_link() {
    const context = await browser.newContext();
    const page = await context.newPage();
    const answer = await page.goto(origin);
    assert.equal(answer.status(), 401);
    await page.getByRole("heading", { name: "Open the link that the server printed" }).waitFor();
    await context.close();
    const program = await fetch(origin, { headers: { Accept: "application/json" } });
    assert.equal(program.status, 401);
    assert.equal((await program.json()).error.kind, "unauthorized");
  },

  async an_instruction_becomes_a_run_and_the_scene_changes() {
    const page = await visitor();
    await planned(page);
    await page.getByRole("heading", { name: "Understood as" }).waitFor();
    assert.match(await page.locator(".goals").innerText(), /juice/);
    assert.match(await page.locator(".effects").innerText(), /juice: on shelf top/);
    const steps = await page.locator(".plan .step").count();
    assert.ok(steps >= 4, `${steps} steps`);
    // The slider shows each step, and keeps its focus while the page is replaced.
    const slider = page.locator("#slider");
    await slider.focus();
    for (let step = 1; step <= steps; step += 1) {
      await page.keyboard.press("ArrowRight");
      await page.getByText(`Step ${step} of ${steps}`).waitFor();
    }
    assert.equal(await slider.evaluate((element) => document.activeElement === element), true);
    assert.equal(await page.locator(".pictures svg").count(), 2);
    await approveAndStart(page, "sim");
    await page.locator(".step.under-way").first().waitFor();
    await isState(page, "done");
    assert.equal(await page.locator(".step.done").count(), steps);
    await page.getByRole("link", { name: "Back to the session" }).click();
    const world = (await api("GET", `/api/sessions/${idOf(page)}/world`)).body;
    assert.match(JSON.stringify(world.object_states["<juice>"]), /shelf_top/);
    assert.match(await page.locator(".pictures desc").textContent(), /shelf top: .*juice/);
    await leave(page);
  },

  async what_was_not_approved_moves_nothing() {
    const page = await visitor();
    await planned(page);
    const session = idOf(page);
    const before = await runs();
    const plan = await page.locator('input[name="plan"]').first().inputValue();
    const post = (place, form, headers = {}) =>
      page.context().request.post(origin + place, { form, headers: { Origin: origin, Accept: "text/html", ...headers }, maxRedirects: 0 });
    // Another hash: the page says so beside the button.
    const other = await post(`/sessions/${session}/approve`, { plan: "0".repeat(32), robot: "quick" });
    assert.equal(other.status(), 409);
    assert.match(await other.text(), /Not done:/);
    // Another origin, and none.
    for (const headers of [{ Origin: "http://evil.example" }, { Origin: "null" }, { Origin: "" }]) {
      const foreign = await post(`/sessions/${session}/approve`, { plan, robot: "quick" }, headers);
      assert.equal(foreign.status(), 403, JSON.stringify(headers));
    }
    assert.equal((await api("GET", `/api/sessions/${session}`)).body.state, "plan");
    // A GET changes nothing, and another type of body is no form.
    const got = await page.context().request.get(`${origin}/sessions/${session}/approve?plan=${plan}&robot=quick`, { maxRedirects: 0 });
    assert.equal(got.status(), 303);
    const text = await page.context().request.post(`${origin}/sessions/${session}/accept`, {
      data: `plan=${plan}`, headers: { Origin: origin, Accept: "text/html", "Content-Type": "text/plain" } });
    assert.equal(text.status(), 400);
    const long = await post(`/sessions/${session}/feedback`, { text: "x".repeat(70_000) });
    assert.equal(long.status(), 413);
    assert.equal(await runs(), before);
    // Twice: the second start finds the approval used.
    const approved = await post(`/sessions/${session}/approve`, { plan, robot: "quick" });
    const approval = new URL(approved.headers().location, origin).searchParams.get("approval");
    assert.equal((await post(`/sessions/${session}/start`, { approval })).status(), 303);
    await until(async () => (await api("GET", `/api/sessions/${session}`)).body.accepted[0].pending === false);
    assert.equal((await post(`/sessions/${session}/start`, { approval })).status(), 409);
    assert.equal(await runs(), before + 1);
    await leave(page);
  },

  async an_approval_ends_with_its_world_and_its_time() {
    const page = await visitor();
    await planned(page);
    const session = idOf(page);
    await page.getByRole("button", { name: /approve for quick$/ }).click();
    await page.getByRole("button", { name: "Start on quick" }).waitFor();
    const before = await runs();
    const seen = { states: { "<cloth>": "on_something(<floor>)" } };
    assert.equal((await api("POST", `/api/sessions/${session}/observed`, seen)).status, 200);
    await page.waitForTimeout(900);
    await page.getByRole("button", { name: "Start on quick" }).click();
    await page.locator(".problem", { hasText: /world has changed|another plan/ }).waitFor();
    assert.equal(await runs(), before);
    // Expiry.
    await planned(page);
    const other = idOf(page);
    const { plan } = (await api("GET", `/api/sessions/${other}`)).body.proposal;
    await api("POST", `/api/sessions/${other}/accept`, { plan });
    const approval = (await api("POST", `/api/sessions/${other}/approve`, { plan, robot: "quick", expires_s: 1 })).body.id;
    await page.goto(`${origin}/sessions/${other}?approval=${approval}`);
    await page.waitForTimeout(1500);
    await page.getByRole("button", { name: "Start on quick" }).click();
    await page.locator(".problem", { hasText: "expired" }).waitFor();
    assert.equal(await runs(), before);
    await leave(page);
  },

  async the_stop_works_while_everything_else_hangs() {
    const page = await visitor();
    await planned(page);
    await approveAndStart(page, "slow");
    await page.locator(".step.under-way").waitFor();
    // All connections that a browser has to a server are taken, and the server answers nothing but the stop.
    await page.evaluate(() => { window.held = Array.from({ length: 5 }, () => new EventSource("/api/events")); });
    await page.waitForTimeout(500);
    await page.context().route("**/*", (route) => (route.request().url().endsWith("/stop") ? route.continue() : undefined));
    await page.evaluate(() => { for (let i = 0; i < 8; i += 1) fetch(`/fragment?${i}`).catch(() => {}); });
    const began = Date.now();
    await page.getByRole("button", { name: "Stop slow" }).click();
    await page.getByText(/^Stop sent at/).waitFor();
    assert.ok(Date.now() - began < 1500, `${Date.now() - began} ms`);
    await until(async () => (await api("GET", `/api/runs/${idOf(page)}`)).body.state === "stopped");
    await page.context().unrouteAll({ behavior: "ignoreErrors" });
    await page.reload();
    await isState(page, "stopped");
    assert.match(await page.locator(".end").innerText(), /Stopped/);
    await leave(page);
  },

  async escape_stops_only_when_it_is_held() {
    const page = await visitor();
    await planned(page);
    await approveAndStart(page, "slow");
    await page.locator(".step.under-way").waitFor();
    await page.keyboard.press("Escape");
    await page.keyboard.press("Escape");
    await page.waitForTimeout(1300);
    assert.equal(await page.locator("#stopped").innerText(), "");
    await page.keyboard.down("Escape");
    await isState(page, "stopped");
    await page.keyboard.up("Escape");
    await leave(page);
  },

  async a_server_that_is_gone_is_said_at_the_stop() {
    const page = await visitor();
    await page.context().route("**/api/stop", (route) => route.abort());
    await page.getByRole("button", { name: "Stop all robots" }).click();
    await page.getByText(/The stop failed.*emergency stop/).waitFor();
    await page.context().unrouteAll({ behavior: "ignoreErrors" });
    await page.getByText(/^Stop sent at/).waitFor();
    await leave(page);
  },

  async everything_works_with_the_keyboard_alone() {
    const page = await visitor();
    const tabTo = async (name) => {
      for (let press = 0; press < 80; press += 1) {
        await page.keyboard.press("Tab");
        const here = await page.evaluate(() => document.activeElement?.textContent?.trim() ?? "");
        if (name.test(here)) return;
      }
      assert.fail(`no way to ${name}`);
    };
    await tabTo(/^Begin in pantry$/);
    await page.keyboard.press("Enter");
    await page.waitForURL(/\/sessions\//);
    await page.keyboard.press("/");
    await page.keyboard.type("Put the juice on top of the shelf");
    await page.keyboard.press("Enter");
    await isState(page, "plan");
    await page.keyboard.press("ArrowRight");
    await page.getByText(/^Step 1 of/).waitFor();
    await tabTo(/approve for quick$/);
    await page.keyboard.press("Enter");
    await page.getByRole("button", { name: "Start on quick" }).waitFor();
    await page.waitForTimeout(900);
    await tabTo(/^Start on quick$/);
    await page.keyboard.press("Enter");
    await page.waitForURL(/\/runs\//);
    await isState(page, "done");
    await leave(page);
  },

  async everything_works_without_the_script() {
    const page = await visitor({ script: false });
    const stateIs = async (state) => {
      for (let tries = 0; tries < 40; tries += 1) {
        if ((await page.locator(`#state[data-state="${state}"]`).count()) > 0) return;
        await page.waitForTimeout(250);
        await page.reload();
      }
      assert.fail(`${state} at ${page.url()}`);
    };
    await begin(page);
    await instruct(page, "Put the juice on top of the shelf");
    await stateIs("plan");
    await page.getByRole("link", { name: "Next" }).click();
    await page.getByText(/^Step 1 of/).waitFor();
    await page.getByRole("button", { name: /approve for slow$/ }).click();
    await page.getByRole("button", { name: "Start on slow" }).click();
    await stateIs("running");
    await page.getByRole("button", { name: "Stop slow" }).click();
    assert.match(page.url(), /stop=sent/);
    await stateIs("stopped");
    await leave(page);
  },

  async thinking_is_cancelled_and_questions_are_answered() {
    const page = await visitor();
    await begin(page);
    await instruct(page, "wait for me");
    await isState(page, "thinking");
    await page.getByText(/The model: reading/).waitFor();
    await page.getByRole("button", { name: "Cancel" }).click();
    await isState(page, "ready");
    await instruct(page, "Bring the drink");
    await isState(page, "question");
    await page.getByRole("heading", { name: "Which drink?" }).waitFor();
    await page.getByLabel("Your answer").fill("the juice on top of the shelf");
    await page.getByRole("button", { name: "Answer" }).click();
    await isState(page, "plan");
    // What is open and written stays while the page around it is replaced.
    await page.locator("summary", { hasText: "Say what is to be different" }).click();
    const feedback = page.locator("#feedback");
    await feedback.pressSequentially("not so");
    await page.evaluate(() => document.querySelector("#step-2 .number").click());
    await page.getByText("Step 2 of 6").waitFor();
    await page.keyboard.type(" fast");
    assert.equal(await feedback.inputValue(), "not so fast");
    await page.getByRole("button", { name: "Only accept" }).click();
    await isState(page, "ready");
    await page.getByRole("button", { name: "Undo the last one" }).click();
    await page.locator("#accepted").waitFor({ state: "detached" });
    await leave(page);
  },

  async a_failed_form_keeps_the_text_and_says_why() {
    const page = await visitor();
    await begin(page);
    const session = idOf(page);
    const stale = await visitor();
    await stale.goto(`${origin}/sessions/${session}`);
    await stale.context().route("**/fragment*", (route) => route.abort());
    await instruct(page, "Bring the drink");
    await isState(page, "question");
    await instruct(stale, "Put the butter on the counter & wait <b>");
    await stale.locator(".problem").first().waitFor();
    assert.equal((await api("GET", `/api/sessions/${session}`)).body.state, "question");
    await stale.getByText("You wrote: Put the butter on the counter & wait <b>").waitFor();
    await leave(page);
    await leave(stale);
  },

  async what_is_left_out_is_in_front() {
    const page = await visitor();
    await planned(page, "Put the cereal on the counter and be careful with everything fragile");
    await page.getByRole("heading", { name: "Not in the plan" }).waitFor();
    assert.match(await page.locator(".left-out").innerText(), /careful with everything fragile/);
    await leave(page);
  },

  async hostile_names_are_text() {
    const page = await visitor();
    const name = '<img src=x onerror="document.title=1">';
    const environment = { assets: ["<desk>", "<shelf top>"], objects: ["<juice>"], object_states: { "<juice>": "on_something(<desk>)" } };
    const made = await api("POST", "/api/sessions", { domain: "household", environment });
    if (made.status === 201) await page.goto(`${origin}/sessions/${made.body.id}`);
    await instruct(page, `${name} juice on top of the shelf \u202e reversed`);
    await isState(page, "plan", "question", "no_plan", "consent");
    assert.equal(await page.locator("img").count(), 0);
    assert.ok(!(await page.content()).includes("\u202e"));
    await leave(page);
  },

  async nothing_is_sent_twice() {
    const page = await visitor();
    await planned(page);
    const before = await runs();
    await page.getByRole("button", { name: /approve for quick$/ }).dblclick();
    await page.getByRole("button", { name: "Start on quick" }).waitFor();
    assert.equal(await runs(), before);
    assert.equal((await api("GET", `/api/sessions/${idOf(page)}`)).body.accepted.length, 1);
    await page.waitForTimeout(900);
    await page.getByRole("button", { name: "Start on quick" }).dblclick();
    await page.waitForURL(/\/runs\//);
    assert.equal(await runs(), before + 1);
    await leave(page);
  },

  async every_page_is_clean_for_axe_and_fits_every_screen() {
    const tours = Object.keys(WIDTHS).flatMap((size) => ["light", "dark"].map((scheme) => [size, scheme]));
    // The sample has two of the six; all of them take two minutes.
    const chosen = process.env.LONGSTEP_PAGE_SAMPLE ? [["phone", "dark"], ["laptop", "light"]] : tours;
    for (const [size, scheme] of chosen) await tour(size, scheme);
  },
};

/** Goes through all states of the pages, looks at each with axe, and takes its picture. */
async function tour(size, scheme) {
  const page = await visitor({ size, scheme });
  const look = async (name) => {
    await page.waitForTimeout(120);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    if (shots) {
      mkdirSync(shots, { recursive: true });
      await page.screenshot({ path: path.join(shots, `${name}-${size}-${scheme}.png`), fullPage: size !== "wall" });
    }
    assert.ok(wide <= 0, `${name} is ${wide} px too wide at ${size}`);
    // Faults of axe itself, such as inline styles, are not those of the page.
    const faults = page.faults.length;
    await page.evaluate(axe);
    const { violations } = await page.evaluate(() => window.axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"] }));
    page.faults.length = faults;
    const found = violations.map((own) => `${name} ${size} ${scheme}: ${own.id}: ${own.nodes.map((node) => `${node.target} ${node.any[0]?.message ?? ""}`).join(" | ")}`);
    assert.deepEqual(found, []);
  };
  await begin(page);
  await look("ready");
  await instruct(page, "wait for me");
  await isState(page, "thinking");
  await look("thinking");
  await page.getByRole("button", { name: "Cancel" }).click();
  await isState(page, "ready");
  await instruct(page, "Bring the drink");
  await isState(page, "question");
  await look("question");
  await page.getByLabel("Your answer").fill("the juice on top of the shelf");
  await page.getByRole("button", { name: "Answer" }).click();
  await isState(page, "plan");
  await page.locator("#step-4 .number").click();
  await page.getByText(/^Step 4 of/).waitFor();
  await look("plan");
  await page.getByRole("button", { name: /approve for sim$/ }).click();
  await page.getByRole("button", { name: "Start on sim" }).waitFor();
  await look("approved");
  await page.waitForTimeout(900);
  await page.getByRole("button", { name: "Start on sim" }).click();
  await page.waitForURL(/\/runs\//);
  await page.locator(".step.done").first().waitFor();
  await look("running");
  await page.getByRole("button", { name: "Pause after this step" }).click();
  await isState(page, "paused");
  await look("paused");
  await page.getByRole("button", { name: "Continue" }).click();
  await isState(page, "done");
  await look("done");
  await page.getByRole("link", { name: "Back to the session" }).click();
  await look("after");
  await planned(page, "Put the cereal on the counter and be careful with everything fragile");
  await look("left-out");
  await approveAndStart(page, "clumsy");
  await isState(page, "asking", "done", "stopped");
  await look("asking");
  await page.getByRole("button", { name: "Stop clumsy" }).click();
  await page.getByText(/^Stop sent at/).waitFor();
  await isState(page, "stopped", "done");
  await look("stopped");
  await begin(page, "kitchen");
  await instruct(page, "If the cream has expired put it in the scrap bin, otherwise on the ledge");
  await isState(page, "plan", "consent", "question", "no_plan");
  await look("branches");
  if (await page.getByRole("button", { name: "Only accept" }).count()) {
    await page.getByRole("button", { name: "Only accept" }).click();
    await isState(page, "endings", "ready");
    await look("endings");
  }
  await begin(page);
  await instruct(page, "Put the juice up there without touching it");
  await isState(page, "no_plan");
  await look("no-plan");
  await page.goto(origin);
  await look("start");
  await page.goto(`${origin}/audit`);
  await look("audit");
  await page.goto(`${origin}/nothing`);
  await look("missing");
  await page.context().clearCookies();
  await page.goto(origin);
  await look("stranger");
  await leave(page);
}

async function until(is) {
  for (let tries = 0; tries < 200; tries += 1) {
    if (await is()) return;
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  assert.fail(`never: ${is}`);
}

let failures = 0;
try {
  for (const [name, test] of Object.entries(cases)) {
    if (only && !name.includes(only)) continue;
    const began = Date.now();
    try {
      await test();
      console.log(`ok   ${name} (${Date.now() - began} ms)`);
    } catch (error) {
      failures += 1;
      console.log(`FAIL ${name}\n     ${String(error.stack).split("\n").slice(0, 30).join("\n     ")}`);
    }
  }
} finally {
  await browser.close();
  program.kill();
}
process.exitCode = failures ? 1 : 0;

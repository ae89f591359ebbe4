// The page's one script: it sends files and answers, and shows what came of them. All words about
// recordings come from the server; a part of the page is replaced by the same part of a new page.
"use strict";

const byId = (name) => document.getElementById(name);
const POLL = 700; // ms between two looks at a diagnosis: it is slow, and a person reads along
const PAUSE = 500; // ms without a key before answers are sent: nobody wants to be told of half a number

async function ask(method, address, body) {
  let answer;
  try {
    answer = await fetch(address, { method, body });
  } catch {
    throw new Error("The server does not answer; see the terminal in which tp-jax serve was started.");
  }
  if (!answer.ok) throw new Error((await answer.text()).trim() || `The server answered ${answer.status}.`);
  return answer;
}

async function refresh(...parts) {
  const text = await (await ask("GET", "/")).text();
  const anew = new DOMParser().parseFromString(text, "text/html");
  const focus = document.activeElement.id;
  for (const name of parts) byId(name).replaceWith(document.adoptNode(anew.getElementById(name)));
  if (focus && document.activeElement.id !== focus) byId(focus)?.focus(); // it was replaced
  if (parts.includes("recordings")) showRuns();
  if (parts.includes("diagnose")) showJob(JSON.parse(byId("diagnose").dataset.job));
}

function say(list, text, fault) {
  const line = document.createElement("li");
  line.textContent = text;
  if (fault) line.className = "fault";
  list.append(line);
}

// Files -----------------------------------------------------------------------------------------

async function upload(files) {
  const list = byId("uploads");
  const most = Number(document.querySelector("main").dataset.upload);
  list.replaceChildren();
  if (waiting && canAnswer()) await send(); // what was typed is kept
  let added = 0;
  // a campaign.toml of one's own says what the others are
  files.sort((a, b) => (b.name === "campaign.toml") - (a.name === "campaign.toml"));
  for (const file of files) {
    if (file.size > most) {
      say(list, `${file.name} has more than ${most / 1e6} MB; put it into the folder by hand.`, true);
      continue;
    }
    try {
      await ask("PUT", `/recordings/${encodeURIComponent(file.name)}`, file);
      added += 1;
    } catch (fault) {
      say(list, fault.message, true);
    }
  }
  byId("files").value = "";
  if (added) say(list, added === 1 ? "1 file was added." : `${added} files were added.`);
  if (!added) return;
  if (waiting && canAnswer()) await send(); // what was typed meanwhile is kept
  await sending;
  await refresh("recordings", "check", "diagnose");
  if (canAnswer()) await send(); // B1 may have been typed before there was a file
}

const drop = byId("drop");
// a file that misses the frame must not take the place of the page
for (const name of ["dragover", "drop"]) {
  document.addEventListener(name, (event) => event.preventDefault());
}
document.addEventListener("dragover", () => drop.classList.add("over"));
document.addEventListener("dragleave", (event) => {
  if (!event.relatedTarget) drop.classList.remove("over");
});
document.addEventListener("drop", (event) => {
  drop.classList.remove("over");
  if (event.dataTransfer.files.length) upload([...event.dataTransfer.files]);
});
byId("files").addEventListener("change", (event) => upload([...event.target.files]));

// Answers ---------------------------------------------------------------------------------------

function showRuns() {
  for (const card of document.querySelectorAll(".card")) {
    const kind = card.querySelector("[name=kind]");
    if (!kind) continue;
    card.querySelector(".omega").classList.toggle("gone", kind.value !== "commanded");
    card.classList.toggle("unused", !card.querySelector("[name=used]").checked);
  }
}

function answers() {
  const runs = {};
  for (const card of document.querySelectorAll(".card")) {
    const kind = card.querySelector("[name=kind]");
    if (!kind) continue;
    runs[card.dataset.name] = {
      used: card.querySelector("[name=used]").checked,
      kind: kind.value,
      omega: card.querySelector("[name=omega]").value,
    };
  }
  return { B1: byId("B1").value, runs };
}

// whether there is a recording to say anything about, and the campaign.toml is the page's to write
function canAnswer() {
  return document.querySelector(".card [name=kind]:enabled") !== null;
}

let waiting = 0;
let sent = 0;
let sending = Promise.resolve();
function send() {
  clearTimeout(waiting);
  waiting = 0;
  sending = sendNow();
  return sending;
}

async function sendNow() {
  const turn = (sent += 1);
  let told = "";
  try {
    told = (await (await ask("POST", "/answers", JSON.stringify(answers()))).json()).fault;
    if (turn === sent && !told) await refresh("check", "diagnose");
  } catch (fault) {
    told = fault.message;
  }
  if (told) byId("start").disabled = true;
  if (turn === sent) byId("answer-fault").textContent = told;
}

document.addEventListener("input", (event) => {
  if (!event.target.closest("#recordings") && event.target.id !== "B1") return;
  showRuns();
  clearTimeout(waiting);
  if (canAnswer()) waiting = setTimeout(send, PAUSE);
});

// Diagnosis -------------------------------------------------------------------------------------

let watching;
function showJob(job) {
  const running = job.state === "running";
  byId("progress").hidden = !running;
  byId("cancel").hidden = !running;
  if (running) {
    byId("start").disabled = true;
    if (byId("stage").textContent !== job.stage) byId("stage").textContent = job.stage;
    byId("seconds").textContent = `${Math.round(job.seconds)} s`;
    if (job.part === null) byId("part").removeAttribute("value");
    else byId("part").value = job.part;
    clearTimeout(watching);
    watching = setTimeout(watch, POLL);
  }
  const list = byId("messages");
  const lines = [...job.messages];
  if (job.state === "done") lines.push(`${job.name} is done, after ${Math.round(job.seconds)} s.`);
  if (job.state === "cancelled") lines.push(`${job.name} was cancelled.`);
  if ([...list.children].map((each) => each.textContent).join() !== lines.join()) {
    list.replaceChildren();
    for (const line of lines) say(list, line, job.state === "failed");
  }
}

async function watch() {
  try {
    const job = await (await ask("GET", "/job")).json();
    if (job.state === "running") showJob(job);
    else await refresh("diagnose", "diagnoses");
  } catch (fault) {
    byId("messages").replaceChildren();
    say(byId("messages"), fault.message, true);
    watching = setTimeout(watch, 5 * POLL); // it may answer again
  }
}

const actions = {
  write: send,
  start: async () => {
    if (waiting) send(); // a diagnosis is of what the page shows
    await sending;
    if (byId("start").disabled) return;
    byId("start").disabled = true;
    showJob(await (await ask("POST", "/diagnoses")).json());
    byId("cancel").focus();
  },
  cancel: async () => {
    await ask("DELETE", "/job");
    await refresh("diagnose", "diagnoses");
    byId("start").focus();
  },
};
document.addEventListener("click", async (event) => {
  const act = actions[event.target.id];
  if (!act) return;
  try {
    await act();
  } catch (fault) {
    byId("messages").replaceChildren();
    say(byId("messages"), fault.message, true);
  }
});

showRuns();
showJob(JSON.parse(byId("diagnose").dataset.job));

// The page's one script: it sorts and filters the table of rigs. Without it the table is whole.
"use strict";

const table = document.getElementById("rigs");
const body = table.tBodies[0];
const rows = [...body.rows];
const form = document.getElementById("filters");
const search = document.getElementById("search");
const chosen = [...form.querySelectorAll("select")];

function filter() {
  const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
  let count = 0;
  for (const row of rows) {
    const text = row.textContent.toLowerCase();
    const fits = (select) => !select.value || row.dataset[select.dataset.key] === select.value;
    row.hidden = !(words.every((word) => text.includes(word)) && chosen.every(fits));
    count += !row.hidden;
  }
  document.getElementById("count").textContent = `${count} of ${rows.length} rigs`;
}

function sort(head, column) {
  const up = head.getAttribute("aria-sort") !== "ascending";
  const key = (row) => row.cells[column]?.dataset.by;
  const numbers = rows.every((row) => key(row) === undefined || !Number.isNaN(Number(key(row))));
  rows.sort((a, b) => {
    const [x, y] = [key(a), key(b)];
    if (x === undefined || y === undefined) return (x === undefined) - (y === undefined); // last
    return (numbers ? x - y : x.localeCompare(y, "en", { numeric: true })) * (up ? 1 : -1);
  });
  body.append(...rows);
  for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", up ? "ascending" : "descending");
}

for (const [column, head] of [...table.tHead.rows[0].cells].entries()) {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = head.textContent;
  button.addEventListener("click", () => sort(head, column));
  head.replaceChildren(button);
}
search.addEventListener("input", filter);
for (const select of chosen) select.addEventListener("change", filter);
form.addEventListener("submit", (event) => event.preventDefault());
form.hidden = false;
filter();

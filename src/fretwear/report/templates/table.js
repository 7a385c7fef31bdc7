"use strict";
(function () {
  const table = document.getElementById("case-table");
  const form = document.querySelector("form.filters");
  const body = table.tBodies[0];
  const rows = Array.from(body.rows);
  const heads = Array.from(table.querySelectorAll("[data-sort]"));

  function key(row, column) {
    const cell = row.cells[column];
    if (cell.dataset.value !== undefined) return Number(cell.dataset.value);
    const text = cell.textContent.trim();
    return text === "–" ? null : text;
  }

  function compare(a, b) {
    if (typeof a === "number" && typeof b === "number") return a === b ? 0 : a - b;
    return String(a).localeCompare(String(b), "en", { numeric: true });
  }

  /* Rows without a value come last in either direction. */
  function sort(head, direction) {
    const keyed = rows.map((row) => [key(row, Number(head.dataset.sort)), row]);
    keyed.sort(([a], [b]) =>
      a === null || b === null ? (a === null) - (b === null) : direction * compare(a, b)
    );
    body.append(...keyed.map(([, row]) => row));
    for (const other of heads) other.setAttribute("aria-sort", "none");
    head.setAttribute("aria-sort", direction > 0 ? "ascending" : "descending");
  }

  for (const head of heads) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    head.setAttribute("aria-sort", "none");
    button.addEventListener("click", () => {
      sort(head, head.getAttribute("aria-sort") === "ascending" ? -1 : 1);
    });
  }

  const selects = Array.from(form.querySelectorAll("select"));
  const search = form.querySelector("input[type=search]");
  const count = form.querySelector("output");

  function filter() {
    const wanted = search.value.trim().toLowerCase();
    let shown = 0;
    for (const row of rows) {
      const fits = selects.every(
        ({ value, dataset }) => !value || row.cells[dataset.column].textContent === value
      );
      row.hidden = !(fits && row.textContent.toLowerCase().includes(wanted));
      shown += row.hidden ? 0 : 1;
    }
    count.textContent = shown + " of " + rows.length + " shown";
  }

  form.addEventListener("input", filter);
  form.addEventListener("submit", (event) => event.preventDefault());
  form.addEventListener("reset", () => setTimeout(filter));
  form.hidden = rows.length < 2;
  filter();
})();

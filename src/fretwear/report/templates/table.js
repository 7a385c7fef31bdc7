"use strict";
(function () {
  const table = document.getElementById("case-table");
  const form = document.querySelector("form.filters");
  if (!table || !form) return;
  const body = table.tBodies[0];
  const rows = Array.from(body.rows);
  const order = columnOrder();

  /* Cells of a head with two rows, in the order of the columns below them. */
  function columnOrder() {
    const below = Array.from(table.tHead.rows[1].cells);
    const columns = [];
    for (const cell of table.tHead.rows[0].cells) {
      if (cell.rowSpan > 1) columns.push(cell);
      else for (let i = 0; i < cell.colSpan; i += 1) columns.push(below.shift());
    }
    return columns;
  }

  function key(row, column) {
    const cell = row.cells[column];
    if (cell.dataset.value !== undefined) return Number(cell.dataset.value);
    const text = cell.textContent.trim();
    return text === "–" ? null : text;
  }

  function compare(a, b) {
    if (a === b) return 0;
    if (typeof a === "number" && typeof b === "number") return a - b;
    return String(a).localeCompare(String(b), "en", { numeric: true });
  }

  function sort(column, direction) {
    const keyed = rows.map((row) => [key(row, column), row]);
    keyed.sort(function (first, second) {
      if (first[0] === null || second[0] === null) {
        return (first[0] === null) - (second[0] === null);
      }
      return direction * compare(first[0], second[0]);
    });
    body.append(...keyed.map((pair) => pair[1]));
    order.forEach(function (head, index) {
      const sorted = direction > 0 ? "ascending" : "descending";
      head.setAttribute("aria-sort", index === column ? sorted : "none");
    });
  }

  order.forEach(function (head, column) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    head.setAttribute("aria-sort", "none");
    button.addEventListener("click", function () {
      sort(column, head.getAttribute("aria-sort") === "ascending" ? -1 : 1);
    });
  });

  const selects = Array.from(form.querySelectorAll("select"));
  const search = form.querySelector("input[type=search]");
  const count = form.querySelector("output");
  const labels = new Map(rows.map((row) => [row, JSON.parse(row.dataset.labels)]));

  function filter() {
    const wanted = search.value.trim().toLowerCase();
    let shown = 0;
    for (const row of rows) {
      const fits = selects.every(
        (select) => !select.value || labels.get(row)[select.dataset.key] === select.value
      );
      row.hidden = !(fits && row.textContent.toLowerCase().includes(wanted));
      shown += row.hidden ? 0 : 1;
    }
    count.textContent = shown + " of " + rows.length + " shown";
  }

  form.addEventListener("input", filter);
  form.addEventListener("submit", (event) => event.preventDefault());
  form.addEventListener("reset", () => setTimeout(filter));
  form.hidden = false;
  filter();
})();

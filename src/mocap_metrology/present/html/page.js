"use strict";
// Tables that can be sorted and searched, and figures that zoom. A page without it still reads.
(() => {
  const order = new Intl.Collator("en", { numeric: true });
  const digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  const value = (cell) => (cell?.innerText ?? "").trim();

  // 9.26×10⁻⁷, −5.20, 13 195, "< 0.3": the number that a cell begins with, or NaN
  function number(text) {
    const plain = text
      .replace(/−/g, "-")
      .replace(/\u202f/g, "")
      .replace(/×10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)/, (_, p) =>
        "e" + [...p].map((c) => (c === "⁻" ? "-" : digits.indexOf(c))).join(""));
    const power = /\)(e-?\d+)/.exec(plain);
    return parseFloat(plain.replace(/^[<>≤≥~±(†*+ ]+/, "").replace(/^(-?[\d.]+) .*/, `$1${power?.[1] ?? ""}`));
  }

  function compare(a, b) {
    const [x, y] = [number(a), number(b)];
    if (isNaN(x) || isNaN(y)) return isNaN(x) - isNaN(y) || order.compare(a, b);
    return x - y;
  }

  function sortable(table) {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, k) => {
      const button = document.createElement("button");
      button.append(...head.childNodes);
      head.append(button);
      button.onclick = () => {
        const up = head.getAttribute("aria-sort") !== "ascending";
        heads.forEach((other) => other.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", up ? "ascending" : "descending");
        const rows = [...table.tBodies[0].rows];
        const numeric = head.classList.contains("n");
        const by = numeric ? compare : order.compare;
        rows.sort((a, b) => {
          const [x, y] = [value(a.cells[k]), value(b.cells[k])];
          if (!x || !y || x === "–" || y === "–") return (!x || x === "–") - (!y || y === "–");
          return up ? by(x, y) : by(y, x);
        });
        table.tBodies[0].append(...rows);
      };
    });
  }

  function tools(table) {
    const bar = document.createElement("div");
    bar.className = "tools";
    if (table.tBodies[0].rows.length > 8) {
      const search = document.createElement("input");
      search.type = "search";
      search.placeholder = "search this table";
      search.setAttribute("aria-label", "search this table");
      search.oninput = () => {
        const wanted = search.value.toLowerCase().split(/\s+/);
        for (const row of table.tBodies[0].rows) {
          const text = row.textContent.toLowerCase();
          row.hidden = !wanted.every((word) => text.includes(word));
        }
      };
      bar.append(search);
    }
    if (table.querySelector(".more")) {
      const all = document.createElement("button");
      const name = () => (table.classList.contains("all") ? "fewer columns" : "all columns");
      all.onclick = () => (table.classList.toggle("all"), (all.textContent = name()));
      all.textContent = name();
      bar.append(all);
    }
    if (bar.children.length) table.parentNode.before(bar);
  }

  function viewer(first) {
    const dialog = document.createElement("dialog");
    const picture = document.createElement("img");
    const close = document.createElement("button");
    close.textContent = "close";
    close.onclick = () => dialog.close();
    dialog.append(close, picture);
    first.closest(".mm").append(dialog);
    let [x, y, scale, from] = [0, 0, 1, null];
    const place = () => (picture.style.transform = `translate(${x}px, ${y}px) scale(${scale})`);
    const zoom = (factor, atX, atY) => {
      const next = Math.min(Math.max(scale * factor, 0.2), 40);
      [x, y, scale] = [atX - ((atX - x) * next) / scale, atY - ((atY - y) * next) / scale, next];
      place();
    };
    dialog.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoom(Math.exp(-event.deltaY / 400), event.clientX, event.clientY);
    }, { passive: false });
    picture.onpointerdown = (event) => {
      event.preventDefault();
      picture.setPointerCapture(event.pointerId);
      from = [event.clientX - x, event.clientY - y];
    };
    picture.onpointermove = (event) => {
      if (!from) return;
      [x, y] = [event.clientX - from[0], event.clientY - from[1]];
      place();
    };
    picture.onpointerup = picture.onpointercancel = () => (from = null);
    dialog.onkeydown = (event) => {
      const factor = { "+": 1.25, "-": 0.8 }[event.key];
      if (factor) zoom(factor, innerWidth / 2, innerHeight / 2);
    };
    return (image) => {
      const fit = Math.min(innerWidth / image.naturalWidth, innerHeight / image.naturalHeight);
      picture.width = image.naturalWidth * fit;
      picture.src = image.src;
      picture.alt = image.alt;
      [x, y, scale] = [(innerWidth - picture.width) / 2, 0, 1];
      place();
      dialog.showModal();
    };
  }

  document.querySelectorAll(".mm table").forEach((table) => (sortable(table), tools(table)));
  // Within Snakemake's report a page has no address, so that its links lead nowhere
  if (location.protocol === "data:") {
    document.querySelectorAll(".mm nav").forEach((links) => links.remove());
    document.querySelectorAll(".mm a").forEach((link) =>
      link.replaceWith(...(link.dataset.inside ? [link.dataset.inside] : link.childNodes)));
    document.querySelectorAll(".mm .inside").forEach((words) => (words.hidden = false));
  }
  const images = document.querySelectorAll(".mm figure img");
  if (images.length) {
    const show = viewer(images[0]);
    images.forEach((image) => {
      (image.closest("a") ?? image).onclick = (event) => (event.preventDefault(), show(image));
    });
  }
})();

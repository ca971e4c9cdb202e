# SPDX-License-Identifier: GPL-2.0-or-later
"""Checks the built site: nothing is fetched from elsewhere, and every internal link has its target.

``python docs/making/check.py docs/_build/html``; exit status 1 where something is wrong.
"""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {"script": "src", "img": "src", "iframe": "src", "link": "href", "source": "src", "video": "src"}
"""Tags by which a browser fetches something, and the attribute that names it."""
NOT_LOADED = {"canonical", "author", "search", "next", "prev", "index", "genindex"}


class Page(HTMLParser):
    """Places that a page can be entered at, its links, and what it fetches."""

    def __init__(self, text: str):
        super().__init__()
        self.ids: set[str] = {"", "top"}
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take in one tag."""
        values = {name: value or "" for name, value in attrs}
        self.ids |= {values[name] for name in ("id", "name") if name in values}
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        if tag in LOADED and LOADED[tag] in values and values.get("rel") not in NOT_LOADED:
            self.fetched.append(values[LOADED[tag]])


def faults(site: Path) -> list[str]:
    """What is wrong with a built site, a line each."""
    pages = {
        path: Page(path.read_text())
        for path in sorted(site.rglob("*.html"))
        if not {"_static", "reports"} & set(path.parts)
    }
    found = []
    for path, page in pages.items():
        name = path.relative_to(site)
        for address in [*page.fetched, *page.links]:
            parts = urlsplit(address)
            outside = parts.scheme not in ("", "file", "data", "mailto") or (parts.netloc and not parts.scheme)
            if outside and address in page.fetched:
                found.append(f"{name}: fetches {address}")
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                found.append(f"{name}: {address} is not there")
            elif target in pages and unquote(parts.fragment) not in pages[target].ids:
                found.append(f"{name}: {address} has no such place")
    return found


def main() -> int:
    """Print what is wrong and return the exit status."""
    site = Path(sys.argv[1]).resolve()
    found = faults(site)
    print("\n".join(found) or f"{len(list(site.rglob('*.html')))} pages: links are fine, nothing is fetched")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())

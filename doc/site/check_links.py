# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""check_links.py FOLDER: does every link of the built pages lead to a file, and to an anchor in it? Asks no network."""

from __future__ import annotations

import sys
from pathlib import Path
from urllib.parse import unquote, urlsplit

from bs4 import BeautifulSoup


def page(path: Path) -> tuple[set[str], list[str]]:
    """Anchors of a page, and where its links, pictures and styles lead."""
    soup = BeautifulSoup(path.read_bytes(), "html.parser")
    anchors = {
        str(tag.get("id") or tag.get("name")) for tag in soup.find_all(lambda tag: tag.get("id") or tag.get("name"))
    }
    return anchors, [
        str(tag.get("href") or tag.get("src")) for tag in soup.find_all(lambda t: t.get("href") or t.get("src"))
    ]


def dead_links(folder: Path) -> list[str]:
    """`page: link` for every link that leads nowhere."""
    pages = {path.resolve(): page(path) for path in sorted(folder.rglob("*.html"))}
    dead = []
    for path, (_, links) in pages.items():
        for link in links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchors = pages[target][0] if target in pages else {""}
            if not target.is_file() or (parts.fragment and target in pages and unquote(parts.fragment) not in anchors):
                dead.append(f"{path.relative_to(folder.resolve())}: {link}")
    return dead


def main(folder: Path) -> int:
    """Print dead links; the exit status."""
    found = dead_links(folder)
    print("\n".join(found) or f"{len(list(folder.rglob('*.html')))} pages, no dead link")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))

"""Pages as their reader finds them."""

from __future__ import annotations

from html.parser import HTMLParser

# Elements that are not closed.
VOID = {"br", "hr", "img", "input", "link", "meta"}


class Page(HTMLParser):
    """Ids, links, pictures, tags and text of a page, parsed strictly: elements close in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.links, self.pictures, self.tags = [], [], [], [], []
        self.text = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.tags.append((tag, given))
        if tag not in VOID:
            self.open.append(tag)
        if "id" in given:
            self.ids.append(given["id"])
        if tag == "img":
            self.pictures.append(given)
        self.links += [given[name] for name in ("href", "src") if name in given]

    def handle_endtag(self, tag):
        assert tag in VOID or self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)

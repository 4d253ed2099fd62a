"""Pages as their reader finds them."""

from __future__ import annotations

from html.parser import HTMLParser
from importlib.resources import files

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


def emulate(chromium, size, scheme="light"):
    """Give the browser's window a size, below 600 a phone's, and a scheme of colours."""
    width, height = size
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
    chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    scheme = [{"name": "prefers-color-scheme", "value": scheme}]
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": scheme})


def overflow(chromium):
    """Pixels by which a page is wider than its window."""
    script = "return document.documentElement.scrollWidth - window.innerWidth"
    return max(chromium.execute_script(script), 0)


def violations(chromium, scheme="light", left_out="none"):
    """Serious barriers to access that axe finds outside of some elements; in the dark, colours."""
    chromium.execute_script(files("axe_core_python").joinpath("axe.min.js").read_text("utf-8"))
    return chromium.execute_async_script(
        "const done = arguments[2];"
        "axe.run({exclude: [[arguments[0]]]}, {resultTypes: ['violations'], ...arguments[1]})"
        ".then(r => done(r.violations.filter(v => ['serious', 'critical'].includes(v.impact))"
        ".map(v => [v.id, v.nodes.length, v.nodes[0].html.slice(0, 200)])));",
        left_out,
        {"runOnly": ["color-contrast"]} if scheme == "dark" else {},
    )

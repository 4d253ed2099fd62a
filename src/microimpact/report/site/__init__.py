"""The report of a run as a static site: pages that need no network and no server."""

PAGES = ("index", "claims", "equations", "tables", "workflow", "run")

"""The report of a run as a static site: pages that need no network and no server."""

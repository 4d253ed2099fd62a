"""The explorer: a page that computes any impact in the browser, from tables made by the kernel."""

"""The explorer: a page that computes any impact in the browser, from tables made by the kernel."""

# In the order in which they run: each knows those before it.
SCRIPTS = ("model.js", "plots.js", "fields.js", "words.js", "views.js", "page.js")
FILES = (*SCRIPTS, "explorer.css")

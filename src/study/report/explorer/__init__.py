"""The explorer: a page that computes any impact in the browser, integrating as the kernel does."""

# In the order in which they run: each knows those before it.
SCRIPTS = (
    *("integrator.js", "model.js"),
    *("plots.js", "fields.js", "words.js", "views.js", "page.js"),
)
FILES = (*SCRIPTS, "explorer.css")

"""What the study asserts about the article: declared criteria, and what came of them."""

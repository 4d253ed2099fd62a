"""The article's campaign: 187 virtual experiments of about 40 events each (Section 2)."""

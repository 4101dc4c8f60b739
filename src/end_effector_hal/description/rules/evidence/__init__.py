"""Rules for evidence: whether the codecs' channels can prove all that the tool needs."""

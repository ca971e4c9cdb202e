"""One run of a case: start, resume, analyse again."""

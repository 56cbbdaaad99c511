"""The page that shows runs: the file that holds it (`document`), and its code."""

"""The page that shows runs: what it is told (`story`), the file that holds it (`document`), its code."""

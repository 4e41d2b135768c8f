"""The app in the browser: pages that start runs of the command line, and draw what those store."""

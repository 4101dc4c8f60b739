"""The process of the line arbiter: its socket, its connections and its replies."""

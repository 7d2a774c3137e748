"""A scene as one HTML file that runs its model by itself, as WebAssembly."""

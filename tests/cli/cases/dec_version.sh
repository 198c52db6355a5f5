nsdf-dec --version

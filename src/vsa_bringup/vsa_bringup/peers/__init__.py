"""Other people's stiffness estimators, written anew from their papers, to be compared with: benches only."""

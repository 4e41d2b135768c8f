"""Where the program works: many scenes drawn at random, each judged by checks that are not the solver's."""

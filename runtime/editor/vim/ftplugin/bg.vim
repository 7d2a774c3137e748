" Settings for .bg files: comments, and two blanks of indentation as `bgc fmt` writes them.
setlocal commentstring=//\ %s comments=s1:/*,mb:*,ex:*/,:///,:// expandtab shiftwidth=2 softtabstop=2

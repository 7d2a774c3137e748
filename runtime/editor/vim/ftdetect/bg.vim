au BufRead,BufNewFile *.bg setfiletype bg

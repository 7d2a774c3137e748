" Vim syntax file of the bgc language. Written by python -m bgc.runtime.editor.colours.
if exists("b:current_syntax")
  finish
endif

syn keyword bgKeyword assert const der domain else equation for function if import in input interface let model output param port project scene set signal state then unknown use
syn keyword bgOperator and not or
syn keyword bgConstant pi time
syn match bgStatement /\v%(^|[;{}])@<=\s*<%(deadline|device|drive|effort|flow|keep|observe|plot|proof|pseudo|require|reset|run|sample|shape|solver|start|step|when)>%(\s*%([:.=,)]|-\>))@!/
syn match bgWord /\v\s@<=<%(against|as|at|colour|every|from|hold|is|main|next|of|offset|out|rest|sampled|to|vary|within)>%(\s*%([:.=,)]|-\>))@!/
syn match bgElement /\v%(:\s*)@<=<%(C|Demux|GY|I|IC|J0|J1|MGY|MR|MSe|MSf|MTF|Mux|R|Se|Sf|TF)>/
syn match bgFunction /\v<%(abs|acos|acosh|asin|asinh|atan|atan2|atanh|block|cbrt|ceil|cos|cosh|cross|data|der|diag|dot|erf|erfc|exp|expm1|eye|floor|fmod|fmu|hypot|interpolate|inv|jacobian|length|log|log10|log1p|max|min|norm|ones|outer|random|sign|sin|sinh|skew|sqrt|stack|sum|tan|tanh|transpose|zeros)>%(\s*\()@=/
syn match bgArrow /\v-\>/
syn match bgNumber /\v<%(\d+%(\.\d+)?|\.\d+)%([eE][+-]?\d+)?%( [A-Za-z_][A-Za-z0-9_]*%([*\/^-]+\w+)*)?/
syn region bgText start=/"/ end=/"/ oneline
syn match bgComment /\/\/.*$/ contains=@Spell
syn match bgDoc /\/\/\/.*$/ contains=@Spell
syn region bgComment start=/\/\*/ end=/\*\// contains=@Spell

hi def link bgKeyword Keyword
hi def link bgOperator Operator
hi def link bgConstant Constant
hi def link bgStatement Statement
hi def link bgWord Keyword
hi def link bgElement Type
hi def link bgFunction Function
hi def link bgArrow Operator
hi def link bgNumber Number
hi def link bgText String
hi def link bgComment Comment
hi def link bgDoc SpecialComment

let b:current_syntax = "bg"

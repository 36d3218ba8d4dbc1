# Puts the bytes of a file as a C++ initializer list into the variable `bytes`, and their number into `size`.
function(bytes_of file bytes size)
  file(READ ${file} hex HEX)
  string(LENGTH "${hex}" digits)
  math(EXPR count "${digits} / 2")
  string(REGEX REPLACE "(..)" "0x\\1," list "${hex}")
  string(REGEX REPLACE "(................................................................................)" "\\1\n"
         list "${list}")
  set(${bytes} "${list}" PARENT_SCOPE)
  set(${size} ${count} PARENT_SCOPE)
endfunction()

# Writes the shaders as C++ string literals: cmake -DOUT=FILE -DDIR=DIRECTORY -DFILES=a,b -P embed_shaders.cmake
string(REPLACE "," ";" FILES "${FILES}")
set(text "")
foreach(file ${FILES})
  file(READ ${DIR}/${file} source)
  string(APPEND text "{\"${file}\", R\"glsl(${source})glsl\"},\n")
endforeach()
file(WRITE ${OUT} "${text}")

/* The OpenGL 3.3 core functions that the renderer uses, looked up by name: a window and a picture in memory have theirs
 * from different libraries, which is why there is no global loader. */
#ifndef PLAY_GL_API_H
#define PLAY_GL_API_H

#include <GL/glcorearb.h>

#define PLAY_GL_FUNCTIONS(X)                                                                                           \
    X(ACTIVETEXTURE, ActiveTexture)                                                                                    \
    X(ATTACHSHADER, AttachShader)                                                                                      \
    X(BINDBUFFER, BindBuffer)                                                                                          \
    X(BINDFRAMEBUFFER, BindFramebuffer)                                                                                \
    X(BINDRENDERBUFFER, BindRenderbuffer)                                                                              \
    X(BINDTEXTURE, BindTexture)                                                                                        \
    X(BINDVERTEXARRAY, BindVertexArray)                                                                                \
    X(BLENDFUNCSEPARATE, BlendFuncSeparate)                                                                            \
    X(BLITFRAMEBUFFER, BlitFramebuffer)                                                                                \
    X(BUFFERDATA, BufferData)                                                                                          \
    X(CHECKFRAMEBUFFERSTATUS, CheckFramebufferStatus)                                                                  \
    X(CLEAR, Clear)                                                                                                    \
    X(CLEARCOLOR, ClearColor)                                                                                          \
    X(COLORMASK, ColorMask)                                                                                            \
    X(COMPILESHADER, CompileShader)                                                                                    \
    X(CREATEPROGRAM, CreateProgram)                                                                                    \
    X(CREATESHADER, CreateShader)                                                                                      \
    X(DELETEBUFFERS, DeleteBuffers)                                                                                    \
    X(DELETEFRAMEBUFFERS, DeleteFramebuffers)                                                                          \
    X(DELETEPROGRAM, DeleteProgram)                                                                                    \
    X(DELETERENDERBUFFERS, DeleteRenderbuffers)                                                                        \
    X(DELETESHADER, DeleteShader)                                                                                      \
    X(DELETETEXTURES, DeleteTextures)                                                                                  \
    X(DELETEVERTEXARRAYS, DeleteVertexArrays)                                                                          \
    X(DEPTHMASK, DepthMask)                                                                                            \
    X(DISABLE, Disable)                                                                                                \
    X(DRAWARRAYS, DrawArrays)                                                                                          \
    X(DRAWBUFFER, DrawBuffer)                                                                                          \
    X(DRAWELEMENTS, DrawElements)                                                                                      \
    X(ENABLE, Enable)                                                                                                  \
    X(ENABLEVERTEXATTRIBARRAY, EnableVertexAttribArray)                                                                \
    X(DISABLEVERTEXATTRIBARRAY, DisableVertexAttribArray)                                                              \
    X(FRAMEBUFFERRENDERBUFFER, FramebufferRenderbuffer)                                                                \
    X(FRAMEBUFFERTEXTURE2D, FramebufferTexture2D)                                                                      \
    X(GENBUFFERS, GenBuffers)                                                                                          \
    X(GENFRAMEBUFFERS, GenFramebuffers)                                                                                \
    X(GENRENDERBUFFERS, GenRenderbuffers)                                                                              \
    X(GENTEXTURES, GenTextures)                                                                                        \
    X(GENVERTEXARRAYS, GenVertexArrays)                                                                                \
    X(GETERROR, GetError)                                                                                              \
    X(GETINTEGERV, GetIntegerv)                                                                                        \
    X(GETPROGRAMIV, GetProgramiv)                                                                                      \
    X(GETSHADERINFOLOG, GetShaderInfoLog)                                                                              \
    X(GETSHADERIV, GetShaderiv)                                                                                        \
    X(GETSTRING, GetString)                                                                                            \
    X(GETUNIFORMLOCATION, GetUniformLocation)                                                                          \
    X(LINKPROGRAM, LinkProgram)                                                                                        \
    X(PIXELSTOREI, PixelStorei)                                                                                        \
    X(POLYGONMODE, PolygonMode)                                                                                        \
    X(POLYGONOFFSET, PolygonOffset)                                                                                    \
    X(READPIXELS, ReadPixels)                                                                                          \
    X(RENDERBUFFERSTORAGEMULTISAMPLE, RenderbufferStorageMultisample)                                                  \
    X(SHADERSOURCE, ShaderSource)                                                                                      \
    X(TEXIMAGE2D, TexImage2D)                                                                                          \
    X(TEXPARAMETERI, TexParameteri)                                                                                    \
    X(UNIFORM1F, Uniform1f)                                                                                            \
    X(UNIFORM1I, Uniform1i)                                                                                            \
    X(UNIFORM2F, Uniform2f)                                                                                            \
    X(UNIFORM3F, Uniform3f)                                                                                            \
    X(UNIFORM3FV, Uniform3fv)                                                                                          \
    X(UNIFORM4F, Uniform4f)                                                                                            \
    X(UNIFORMMATRIX4FV, UniformMatrix4fv)                                                                              \
    X(USEPROGRAM, UseProgram)                                                                                          \
    X(VERTEXATTRIBPOINTER, VertexAttribPointer)                                                                        \
    X(VIEWPORT, Viewport)

/* gl.DrawElements(...) and so on. */
typedef struct play_gl {
#define PLAY_GL_MEMBER(type, name) PFNGL##type##PROC name;
    PLAY_GL_FUNCTIONS(PLAY_GL_MEMBER)
#undef PLAY_GL_MEMBER
} play_gl;

typedef void (*play_gl_function)(void);
/* The function "glDrawElements" of the current context, or NULL. */
typedef play_gl_function (*play_gl_lookup)(const char *name);

/* Fills all of *gl.  Returns NULL, or the name of a function that there is not. */
const char *play_gl_load(play_gl *gl, play_gl_lookup lookup);

#endif

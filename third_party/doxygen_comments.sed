# Shows comments of two slashes to Doxygen as documentation: of what follows, or of what stands before them.
s~^( *)// (namespace|NOLINT|SPDX)~\1//~
s~^( *)// ~\1/// ~
s~([;,{}]) +// ~\1 ///< ~
s~///< (namespace|NOLINT)~// ~

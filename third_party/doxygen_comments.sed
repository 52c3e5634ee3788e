# Shows comments of two slashes to Doxygen as documentation: of what follows, or of what stands before them.
s~^( *)// (namespace|SPDX)~\1//~
s~^( *)// ~\1/// ~
s~([;,{}]) +// ~\1 ///< ~
s~///< NOLINT: ~///< ~
s~///< (namespace|NOLINT)~// ~

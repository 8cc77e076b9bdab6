/* musl's libm.h includes a file of this name, in which a processor may replace some of its functions: none here. */

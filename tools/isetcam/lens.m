function oi = lens(falloff)
% The diffraction-limited lens at f/4 with a focal length of 3.8628 mm: ISETCam's default. `falloff` is 'cos4th' or 'skip'.
oi = oiCreate('diffraction limited');
if nargin < 1, falloff = 'cos4th'; end
oi = oiSet(oi, 'optics', opticsSet(oiGet(oi, 'optics'), 'off axis method', falloff));
end
